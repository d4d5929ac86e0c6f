// Silverman 1986: variance of kernel density estimates.
#include "core/render/pilot.h"

#include <array>
#include <span>
#include <vector>

#include "core/render/gather.h"
#include "core/trace/gathered.h"

namespace photond {

namespace {

constexpr std::uint32_t kSide = 24;    // pixels of the grid, each way
constexpr std::uint64_t kPilotSeed = 0x70696c6f74;

// Of one channel-averaged quantity over a pixel's paths.
struct Moments {
  double count = 0;
  double sum = 0;
  double sum_sq = 0;
  void add(const Rgb& radiance) {
    const double mean = (static_cast<double>(radiance.x) + radiance.y + radiance.z) / 3;
    ++count;
    sum += mean;
    sum_sq += mean * mean;
  }
  double mean() const { return sum / count; }
  double variance() const { return std::max(0.0, sum_sq - sum * sum / count) / (count - 1); }
};

struct PixelNoise {
  double radiance = 0;
  double photons = 0;   // variances
  double paths = 0;
};

// ∫K² of Epanechnikov's kernel, times its area.
constexpr double kKernelNoise = 4.0 / 3;

// The photons of a pass that the gather at the end of a path from the eye expects; infinite where it gathers nowhere.
float expected_photons(const PreparedScene& scene, const RadianceSettings& settings, const Bandwidth& bandwidth, Ray ray,
                       CameraSampler& rng) {
  static constexpr int kLongest = 64;
  float footprint = settings.pixel_width;
  for (int depth = 0; depth < kLongest; ++depth) {
    const Hit hit = scene.accel.intersect(ray);
    if (!hit.found()) break;
    const SurfacePoint surface = make_surface(scene.scene, ray, hit);
    const Bsdf bsdf(scene.scene, surface, -ray.direction);
    footprint += settings.pixel_spread * hit.t;
    if (gathered_lobes(bsdf) != kNoLobe) {
      static constexpr float kSome = 100;
      const float radius_sq = widest_radius_sq(settings, bandwidth, surface.position, footprint);
      const float some_sq = bandwidth.radius_sq(surface.position, kSome * settings.pilot_share);
      return some_sq > 0 ? kSome * radius_sq / some_sq : 0;
    }
    const auto sample = bsdf.sample(Vec3(rng.next4()), kAllLobes, Transport::radiance);
    if (!sample) break;
    ray = spawn_ray(surface, sample->wi);
  }
  return kInfinity;
}

Moments measure_paths(const PreparedScene& scene, const Ray& ray, const RadianceSettings& settings, std::uint64_t seed,
                      std::uint64_t pixel, std::uint32_t count) {
  std::array<Ray, kManyPilotPaths> rays;
  std::array<CameraSampler, kManyPilotPaths> samplers;
  std::array<RadianceSample, kManyPilotPaths> samples{};
  rays.fill(ray);
  for (std::uint32_t i = 0; i < count; ++i) samplers[i] = CameraSampler(seed, i, pixel);
  estimate_incoming(scene, settings, std::span(rays).first(count), std::span(samplers).first(count),
                    std::span(samples).first(count));
  Moments moments;
  for (const RadianceSample& sample : std::span(samples).first(count)) moments.add(sample.radiance);
  return moments;
}

// Light that photons would bring is what paths see beyond those that end where photons would be gathered.
PixelNoise measure_pixel(const PreparedScene& scene, const Ray& ray, const RadianceSettings& paths,
                         const RadianceSettings& ends, const GatherGuide& guide, std::uint64_t pixel,
                         std::uint32_t count) {
  const Moments going_on = measure_paths(scene, ray, paths, kPilotSeed, pixel, count);
  const Moments ending = measure_paths(scene, ray, ends, kPilotSeed + 1, pixel, count);
  CameraSampler rng(kPilotSeed + 2, 0, pixel);
  const double photons = static_cast<double>(expected_photons(scene, paths, guide.global, ray, rng));
  PixelNoise noise{going_on.mean(), ending.variance(), going_on.variance()};
  // The square of the difference, less what is noise of it.
  const double indirect = going_on.mean() - ending.mean();
  const double indirect_sq = indirect * indirect - (going_on.variance() + ending.variance()) / count;
  if (indirect > 0) noise.photons += indirect_sq * kKernelNoise / std::max(photons, 1e-6);
  return noise;
}

}  // namespace

PilotNoise measure_noise(const PreparedScene& scene, const Camera& camera, float aspect, const RadianceSettings& paths,
                         const GatherGuide& guide, std::uint32_t count, const Execution& execution) {
  static const PhotonMap kEmpty;
  RadianceSettings ends = paths;
  ends.technique = Technique::density;
  ends.global = &kEmpty;
  if (ends.caustic == nullptr) ends.caustic = &kEmpty;
  std::vector<PixelNoise> pixels(kSide * kSide);
  parallel_for(execution, pixels.size(), 16, [&](std::size_t i) {
    const Vec2 film{(static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide};
    pixels[i] = measure_pixel(scene, camera_ray(camera, film, aspect), paths, ends, guide, i, count);
  });
  double mean = 0;
  for (const PixelNoise& pixel : pixels) mean += pixel.radiance / static_cast<double>(pixels.size());
  PilotNoise noise;
  for (const PixelNoise& pixel : pixels) {
    // As relMSE: dark pixels count little.
    const double level = pixel.radiance * pixel.radiance + 0.01 * mean * mean;
    if (!(level > 0)) continue;
    noise.photons += pixel.photons / level / static_cast<double>(pixels.size());
    noise.paths += pixel.paths / level / static_cast<double>(pixels.size());
  }
  noise.photons = std::max(0.0, noise.photons);
  return noise;
}

}  // namespace photond
