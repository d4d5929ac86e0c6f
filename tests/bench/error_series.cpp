#include "tests/bench/error_series.h"

#include <chrono>
#include <cmath>

#include "core/film/compare.h"
#include "core/film/error.h"
#include "core/film/reconstruct.h"

namespace photond::bench {
namespace {

// Stands still while something is not to count.
class Clock {
 public:
  double seconds() const { return std::chrono::duration<double>(now() - start_).count(); }
  template <class Work>
  auto without(const Work& work) {
    const auto begin = now();
    auto result = work();
    start_ += now() - begin;
    return result;
  }

 private:
  static std::chrono::steady_clock::time_point now() { return std::chrono::steady_clock::now(); }
  std::chrono::steady_clock::time_point start_ = now();
};

Result<ErrorRecord> measure(const Film& film, const Image& reference, double seconds) {
  const auto comparison = compare_images(film_picture(film), reference);
  if (!comparison) return comparison.error();
  const double relative = estimate_error(film).relative;
  return ErrorRecord{seconds, film.pass_count(), comparison->rel_mse, relative * relative,
                     comparison->median_block_deviation};
}

// Builds maps, and keeps the last ones: all passes of photon_map share theirs.
class LastMaps {
 public:
  explicit LastMaps(const PreparedScene& scene) : scene_(scene) {}
  Result<std::shared_ptr<const PhotonMaps>> operator()(const MapKey& key, const Execution& execution) {
    if (maps_ != nullptr && key_ == key) return maps_;
    maps_ = nullptr;  // frees the memory before the next maps need theirs
    auto built = build_photon_maps(scene_, key, execution);
    if (!built) return built;
    key_ = key;
    return maps_ = *built;
  }

 private:
  const PreparedScene& scene_;
  MapKey key_;
  std::shared_ptr<const PhotonMaps> maps_;
};

}  // namespace

std::vector<double> measured_times(double seconds) {
  constexpr double kFirst = 0.3;  // the sooner a picture, the less its time means beside one pass's
  std::vector<double> times;
  for (int i = static_cast<int>(std::ceil(2 * std::log2(kFirst / 2.5))); 2.5 * std::exp2(i / 2.0) < seconds; ++i) {
    times.push_back(2.5 * std::exp2(i / 2.0));
  }
  times.push_back(seconds);
  return times;
}

Result<std::vector<ErrorRecord>> error_series(const RenderTask& task, const Image& reference,
                                              const std::vector<double>& times, const Execution& execution) {
  LastMaps last(*task.scene);
  const MapSource maps = [&](const MapKey& key, const Execution& e) { return last(key, e); };
  Film film(task.settings.width, task.settings.height);
  std::vector<ErrorRecord> records;
  Clock clock;
  for (auto next = times.begin();;) {
    const auto image = render_pass(task, film.pass_count(), maps, execution);
    if (!image) return image.error();
    // A pass that ends too late is not part of the picture at that time.
    for (const double now = clock.seconds(); next != times.end() && *next < now; ++next) {
      if (film.pass_count() == 0) continue;
      const auto record = clock.without([&] { return measure(film, reference, *next); });
      if (!record) return record.error();
      records.push_back(*record);
    }
    if (next == times.end()) return records;
    add_pass(film, film.pass_count(), *image, execution);
  }
}

}  // namespace photond::bench
