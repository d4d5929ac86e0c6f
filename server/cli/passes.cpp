#include "server/cli/passes.h"

#include <algorithm>

#include "core/film/compare.h"
#include "core/film/error.h"
#include "server/cli/stopwatch.h"

namespace photond {
namespace {

/// Builds maps, keeps the last ones (all passes of `photon_map` share theirs) and adds up what they hold.
class CountingMaps {
 public:
  CountingMaps(const PreparedScene& scene, MapStatistics& statistics)
      : scene_(scene), statistics_(statistics) {}

  Result<std::shared_ptr<const PhotonMaps>> get(const MapKey& key, const Execution& execution) {
    if (last_ != nullptr && key_ == key) return last_;
    const Stopwatch watch;
    last_ = nullptr;  // frees the memory before the next maps need theirs
    auto maps = build_photon_maps(scene_, key, execution);
    if (!maps) return maps;
    last_ = *maps;
    key_ = key;
    count(*last_, key.settings.photons_per_pass, watch.seconds());
    return last_;
  }

 private:
  void count(const PhotonMaps& maps, std::uint32_t emitted, double seconds) {
    MapStatistics& s = statistics_;
    const double n = static_cast<double>(++s.built);
    s.emitted += emitted;
    s.global_photons += maps.global.size();
    s.caustic_photons += maps.caustic.size();
    s.rays += maps.rays;
    s.largest_bytes = std::max(s.largest_bytes, maps.memory_bytes);
    s.seconds += seconds;
    const auto mean = [n](double& sum, double value) { sum += (value - sum) / n; };
    mean(s.ledger.emitted, maps.ledger.emitted);
    mean(s.ledger.absorbed, maps.ledger.absorbed);
    mean(s.ledger.escaped, maps.ledger.escaped);
    mean(s.ledger.truncated, maps.ledger.truncated);
    mean(s.ledger.rejected, maps.ledger.rejected);
  }

  const PreparedScene& scene_;
  MapStatistics& statistics_;
  MapKey key_;
  std::shared_ptr<const PhotonMaps> last_;
};

/// What is done is measured whole even after an interrupt.
MeasuredPass measure(const Film& film, Progress progress, const Image* reference, const Execution& interruptible) {
  const Execution execution{interruptible.arena, {}};
  progress.error = estimate_error(film, execution);
  if (reference == nullptr) return {progress, {}};
  return {progress, compare_images(film_picture(film, execution), *reference)->rel_mse};
}

}  // namespace

Result<Rendering> render_passes(const RenderTask& task, std::uint32_t first, const StopRule& stop,
                                const Image* reference, const Execution& execution, ProgressBar& bar) {
  const Stopwatch watch;
  double comparing = 0;
  Rendering rendering{.film = Film(task.settings.width, task.settings.height)};
  CountingMaps counting(*task.scene, rendering.maps);
  const MapSource maps = [&](const MapKey& key, const Execution& e) { return counting.get(key, e); };
  Progress progress;
  const auto add_to_series = [&] {
    const double begin = watch.seconds();
    rendering.series.push_back(measure(rendering.film, progress, reference, execution));
    progress.error = rendering.series.back().progress.error;
    if (reference != nullptr) comparing += watch.seconds() - begin;
  };
  bar.update(stop, progress);
  while (rendering.stopped_by.empty()) {
    const auto image = render_pass(task, first + progress.passes, maps, execution);
    if (execution.cancelled()) {
      rendering.stopped_by = "interrupt";
      break;
    }
    if (!image) return image.error();
    add_pass(rendering.film, first + progress.passes, *image, execution);
    ++progress.passes;
    progress.seconds = watch.seconds() - comparing;
    if (is_measured(progress.passes)) add_to_series();
    if (const char* rule = rule_met(stop, progress)) rendering.stopped_by = rule;
    bar.update(stop, progress);
  }
  if (progress.passes > 0 && !is_measured(progress.passes)) add_to_series();
  rendering.seconds = progress.seconds;
  return rendering;
}

}  // namespace photond
