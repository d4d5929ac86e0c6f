#include "core/render/radiance.h"

#include <array>
#include <numeric>

#include "core/render/bounces.h"
#include "core/render/path_walks.h"

namespace photond {

namespace {

// The walks from the camera of up to kLanes samples, advanced together, one bounce at a time.
class RadianceWalks {
 public:
  RadianceWalks(const PreparedScene& scene, const RadianceSettings& settings)
      : scene_(scene), settings_(settings), bounces_(scene, settings) {}

  void run(std::span<const Ray> rays, std::span<const CameraSampler> samplers, std::span<RadianceSample> samples,
           std::span<Bands> bands) {
    gathered_ = {};
    bounces_.begin(samples, gathered_);
    for (std::uint32_t i = 0; i < rays.size(); ++i) start(walks_[i], i, rays[i], samplers[i]);
    live_count_ = static_cast<std::uint32_t>(rays.size());
    std::iota(live_.begin(), live_.end(), 0);
    for (Coherence coherence = Coherence::high; live_count_ > 0; coherence = Coherence::none) {
      intersect(coherence);
      advance_all();
      bounces_.shadows.trace();
      begin_branches();
    }
    for (std::uint32_t i = 0; i < samples.size(); ++i) samples[i].radiance += gathered_[i].widest;
    for (std::uint32_t i = 0; i < bands.size(); ++i) bands[i] = gathered_[i].bands;
  }

 private:
  void start(Walk& walk, std::uint32_t sample, const Ray& ray, const CameraSampler& sampler) const {
    walk.path = {};
    walk.path.ray = ray;
    walk.path.medium = start_of(scene_, settings_, ray);
    walk.path.footprint = settings_.pixel_width;
    walk.path.spread = settings_.pixel_spread;
    walk.rng = sampler;
    walk.sample = sample;
  }

  void intersect(Coherence coherence) {
    for (std::uint32_t k = 0; k < live_count_; ++k) rays_.set(k, walks_[live_[k]].path.ray);
    scene_.accel.intersect(rays_, live_count_, coherence, hits_);
  }

  void advance_all() {
    std::uint32_t met = 0;
    for (std::uint32_t k = 0; k < live_count_; ++k) {
      const Walk& walk = walks_[live_[k]];
      const Hit hit = hits_[k];
      if (hit.found()) {
        met_[met] = {live_[k], k};
        surfaces_.set(met++, scene_.placed_at(hit), hit, walk.path.ray.direction);
      } else {
        bounces_.add_environment(walk);
      }
    }
    surfaces_.compute(met);
    live_count_ = 0;
    for (std::uint32_t i = 0; i < met; ++i) {
      Walk& walk = walks_[met_[i].walk];
      const Hit hit = hits_[met_[i].lane];
      const SurfacePoint surface =
          surfaces_.surface(i, scene_.scene, scene_.placed_at(hit), walk.path.ray, hit);
      const bool alive = bounces_.advance(walk, hit, surface);
      ++walk.path.depth;
      live_[live_count_] = met_[i].walk;
      live_count_ += alive;
    }
  }

  // Lets branches begin where there is room.
  void begin_branches() {
    if (bounces_.branches.empty() || live_count_ == kLanes) return;
    std::array<bool, kLanes> taken{};
    for (std::uint32_t k = 0; k < live_count_; ++k) taken[live_[k]] = true;
    for (std::uint32_t i = 0; i < kLanes && !bounces_.branches.empty(); ++i) {
      if (taken[i]) continue;
      walks_[i] = bounces_.branches.back();
      bounces_.branches.pop_back();
      live_[live_count_++] = i;
    }
  }

  const PreparedScene& scene_;
  const RadianceSettings& settings_;
  Bounces bounces_;
  std::array<Walk, kLanes> walks_;
  std::array<std::uint32_t, kLanes + 1> live_;   // those of the walks that go on; one more is written, too
  std::uint32_t live_count_ = 0;
  RayLanes rays_{};                              // of the live walks
  HitLanes hits_;
  struct Met {
    std::uint32_t walk, lane;   // lane: of its hit
  };
  std::array<Met, kLanes> met_;
  SurfaceLanes surfaces_{};                      // of those
  std::array<ScaleEstimate, kLanes> gathered_;
};

}  // namespace

void estimate_incoming(const PreparedScene& scene, const RadianceSettings& settings, std::span<const Ray> rays,
                       std::span<const CameraSampler> samplers, std::span<RadianceSample> samples,
                       std::span<Bands> bands) {
  if (settings.technique == Technique::trace) return PathWalks(scene, settings).run(rays, samplers, samples);
  RadianceWalks walks(scene, settings);
  for (std::size_t first = 0; first < rays.size(); first += kLanes) {
    const std::size_t count = std::min<std::size_t>(kLanes, rays.size() - first);
    walks.run(rays.subspan(first, count), samplers.subspan(first, count), samples.subspan(first, count),
              bands.empty() ? bands : bands.subspan(first, count));
  }
}

}  // namespace photond
