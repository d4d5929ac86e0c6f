#include "server/jobs/estimate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "core/film/error.h"
#include "core/film/film.h"
#include "core/render/render.h"
#include "server/jobs/memory_need.h"
#include "server/jobs/stop_rule.h"

namespace photond {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kPilotPixels = 128 * 128;
constexpr std::uint32_t kPilotPasses = 8;  // as many as an error needs to be known
constexpr double kPilotSeconds = 0.5;      // after two passes and this long it is enough, or for an error:
constexpr double kPilotSecondsForError = 3;

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

template <class T>
std::uint64_t bytes_of(const ZeroedArray<T>& values) {
  return values.size() * sizeof(T);
}

std::uint64_t film_bytes(const Film& film) {
  std::uint64_t bytes = bytes_of(film.complete) + bytes_of(film.block_squares) + bytes_of(film.pass_squares) +
                        bytes_of(film.largest) + bytes_of(film.bands);
  for (const Film::OpenBlock& block : film.open) bytes += bytes_of(block.sum);
  return bytes;
}

/// A few passes of a smaller film, timed by what their cost grows with.
class Pilot {
 public:
  Pilot(const JobSpec& spec, const Execution& execution) : spec_(spec), execution_(execution) {}

  Status run(std::shared_ptr<const PreparedScene> scene, const Camera& camera, std::uint64_t most_memory) {
    const Clock::time_point begin = Clock::now();
    RenderSettings settings = spec_.settings;
    const double pixels = static_cast<double>(settings.width) * settings.height;
    const double shrink = std::min(1.0, std::sqrt(kPilotPixels / pixels));
    settings.width = std::max(1, static_cast<int>(std::lround(settings.width * shrink)));
    settings.height = std::max(1, static_cast<int>(std::lround(settings.height * shrink)));
    scale_ = pixels / (static_cast<double>(settings.width) * settings.height);
    scene_bytes_ = scene->memory_bytes;
    Result<RenderTask> task = make_render_task(std::move(scene), camera, spec_.photons, settings, execution_);
    if (!task) return task.error();
    if (const Status fits = check_memory(memory_need(*task, spec_.settings), most_memory); !fits) return fits;
    plan_ = task->plan;
    prepare_seconds_ = since(begin);
    film_ = Film(settings.width, settings.height);
    while (!enough(since(begin))) {
      if (const Status rendered = pass(*task); !rendered) return rendered;
    }
    return Done{};
  }

  const Plan& plan() const { return plan_; }

  /// Seconds until so many passes are done. The first of them is left out of the rate: it meets cold caches.
  double seconds(std::uint32_t passes) const {
    const std::uint32_t pilot = film_.pass_count();
    const double per_pass = scale_ * later_render_seconds_ / (pilot - 1) + later_map_seconds_ / (pilot - 1);
    std::uint32_t measured = 0;
    for (std::uint32_t i = 1; i <= passes; ++i) measured += is_measured(i);
    return prepare_seconds_ + first_map_seconds_ - later_map_seconds_ / (pilot - 1) + passes * per_pass +
           scale_ * measured * error_seconds_ / pilot;
  }

  /// Passes until the estimated error is this small: it falls with their root.
  std::uint32_t passes_for(double relative_error) const {
    const double ratio = error_.known ? error_.relative / relative_error : 0;
    const double passes = film_.pass_count() * ratio * ratio;
    return static_cast<std::uint32_t>(std::clamp(passes, 8.0, 1e9));
  }

  /// `kept_bytes` of photon maps may stay in the cache.
  std::uint64_t memory_bytes(std::uint32_t passes, double kept_bytes) const {
    const double pixels = scale_ * film_.width * film_.height;
    const double pass = film_.bands.empty() ? sizeof(Rgb) : sizeof(Rgb) + sizeof(Bands);
    // Photons are gathered before they are indexed; of large maps (PhotonCells) less is in use than this.
    constexpr double kMapBuilding = 2;
    const double kept = std::min(kept_bytes, map_bytes_ * (maps_built_ > 1 ? passes : 1));
    return scene_bytes_ + static_cast<std::uint64_t>(kept + kMapBuilding * map_bytes_ + scale_ * film_bytes(film_) +
                                                     pixels * std::max(pass, static_cast<double>(kPictureBytes)));
  }

 private:
  bool enough(double seconds) const {
    const std::uint32_t passes = film_.pass_count();
    const double limit = spec_.stop.relative_error ? kPilotSecondsForError : kPilotSeconds;
    return passes >= kPilotPasses || (passes >= 2 && seconds >= limit);
  }

  Status pass(const RenderTask& task) {
    double map_seconds = 0;
    const MapSource build = [&](const MapKey& key, const Execution& execution) {
      const Clock::time_point begin = Clock::now();
      if (!maps_ || key != map_key_) {
        auto built = build_photon_maps(*task.scene, key, execution);
        if (!built) return built;
        maps_ = *built;
        ++maps_built_;
        map_key_ = key;
      }
      map_bytes_ = static_cast<double>(maps_->memory_bytes);
      map_seconds = since(begin);
      return Result<std::shared_ptr<const PhotonMaps>>(maps_);
    };
    const Clock::time_point begin = Clock::now();
    const Result<PassImage> image = render_pass(task, film_.pass_count(), build, execution_);
    if (!image) return image.error();
    if (execution_.cancelled()) return cancelled();
    add_pass(film_, film_.pass_count(), *image, execution_);
    const double seconds = since(begin) - map_seconds;
    if (film_.pass_count() == 1) {
      first_map_seconds_ = map_seconds;
    } else {
      later_map_seconds_ += map_seconds;
      later_render_seconds_ += seconds;
    }
    const Clock::time_point measuring = Clock::now();
    error_ = estimate_error(film_, execution_);
    error_seconds_ += since(measuring);
    return execution_.cancelled() ? Status(cancelled()) : Done{};
  }

  const JobSpec& spec_;
  const Execution& execution_;
  Plan plan_;
  Film film_;
  ErrorEstimate error_;
  double scale_ = 1;  ///< pixels of the job's film to those of the pilot
  double prepare_seconds_ = 0;
  double first_map_seconds_ = 0;
  double later_map_seconds_ = 0;
  double later_render_seconds_ = 0;
  double error_seconds_ = 0;
  double map_bytes_ = 0;
  int maps_built_ = 0;
  std::uint64_t scene_bytes_ = 0;
  MapKey map_key_;
  std::shared_ptr<const PhotonMaps> maps_;  ///< photon_map asks for the same ones in every pass
};

/// The most passes that end within so many seconds, up to `most`; one always does.
std::uint32_t passes_within(const Pilot& pilot, double seconds, std::uint32_t most) {
  std::uint32_t low = 1;
  while (low < most) {
    const std::uint32_t middle = low + (most - low + 1) / 2;
    if (pilot.seconds(middle) <= seconds)
      low = middle;
    else
      most = middle - 1;
  }
  return low;
}

}  // namespace

Result<JobEstimate> estimate_job(std::shared_ptr<const PreparedScene> scene, const Camera& camera, const JobSpec& spec,
                                 const JobBudget& budget, const Execution& execution) {
  Pilot pilot(spec, execution);
  if (const Status ran = pilot.run(std::move(scene), camera, budget.memory_bytes); !ran) return ran.error();
  std::uint32_t passes = spec.stop.passes.value_or(1'000'000);
  if (spec.stop.relative_error) passes = std::min(passes, pilot.passes_for(*spec.stop.relative_error));
  if (spec.stop.seconds) passes = passes_within(pilot, *spec.stop.seconds, passes);
  return JobEstimate{pilot.plan(), passes, pilot.seconds(passes),
                     pilot.memory_bytes(passes, static_cast<double>(budget.kept_map_bytes))};
}

}  // namespace photond
