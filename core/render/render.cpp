#include "core/render/render.h"

#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>

#include "core/photon/radius.h"
#include "core/render/film_rays.h"
#include "core/render/pilot.h"
#include "core/trace/dispersion.h"
#include "core/trace/enclosing.h"
#include "core/trace/specular.h"

namespace photond {

namespace {

// Of one that is asked for, how many photons it will meet: with too few there is nothing to tell the error by.
PlanItem radius_item(const RenderTask& task) {
  const float radius = task.settings.radius;
  if (radius == 0) return {"radius", true, "chosen for each gather from a pilot map's density and the pixel's footprint"};
  const Bandwidth& global = task.guide->global;
  const bool all = task.plan.method == Method::progressive && !global.densities().empty();
  const float density = (all ? global : task.guide->caustic).median();
  char text[160];
  std::snprintf(text, sizeof text, "widest radius %.4g m in the first pass, as asked; around most photons it holds %.2g others",
                static_cast<double>(radius), static_cast<double>(density * kPi * radius * radius / pilot_share(task.photons)));
  return {"radius", true, text};
}

PlanItem edges_item(const GatherGuide& guide) {
  const std::string count = std::to_string(guide.edges.size());
  return {"edges", guide.edges.size() > 0,
          guide.edges.size() > 0 ? "kernels end at " + count + " open or sharp edges" : "no surface ends or bends sharply"};
}

RadianceSettings radiance_settings(const RenderTask& task, std::uint32_t pass, const PhotonMaps* maps) {
  RadianceSettings settings;
  if (maps != nullptr) {
    settings.global = &maps->global;
    settings.caustic = &maps->caustic;
    if (maps->irradiance.places().size() > 0) settings.irradiance = &maps->irradiance;
    settings.emitted = maps->emitted;
    settings.flux_unit = task.scene->lights.flux_unit();
  }
  settings.guide = task.guide.get();
  settings.pilot_share = pilot_share(task.photons);
  settings.nearest = task.settings.gather_photons;
  settings.max_depth = task.settings.max_depth;
  settings.start = task.start;
  settings.apart = task.camera.orthographic && has_followed_volumes(task.scene->scene);
  settings.most_normal_factor = most_normal_factor(pass);
  // As those of the photons: photon_map has the ones of pass 0 throughout.
  settings.wavelengths = wavelengths_of_pass(task.photons.seed, task.plan.method == Method::photon_map ? 0 : pass);
  if (!task.plan.uses_maps) return settings;
  if (task.plan.method != Method::photon_map) {
    settings.technique = task.plan.method == Method::hybrid ? Technique::merge : Technique::density;
    settings.shrink = static_cast<float>(radius_sq_factor(pass));
    settings.radius_sq = task.settings.radius * task.settings.radius * settings.shrink;
    (task.camera.orthographic ? settings.pixel_width : settings.pixel_spread) =
        pixel_spread(task.camera, task.settings.height);
  } else {
    settings.technique = Technique::final_gather;
    const float reach = task.settings.radius > 0 ? task.settings.radius : widest_reach(*task.scene);
    settings.radius_sq = reach * reach;
  }
  return settings;
}

// What a pixel of a pass takes, in rays of photons: measured on a Cornell box. Where paths that go on gather caustics, as
// long as where all is gathered.
constexpr double kRaysOfPath = 5, kRaysOfGather = 26;

// Paths must be that much better, by few of them and by many: behind a door ajar 8 paths through a pixel tell that
// photons leave twice their noise, 32 a fifteenth, 128 a sixtieth. Many cost up to a fifth of a second, but are traced
// only where few speak for paths.
constexpr double kDoubt = 2;

// Where photons are too sparse in the picture, paths leave less noise in the same time: then theirs is the plan.
Status choose_by_pilot(RenderTask& task, const Execution& execution) {
  RenderSettings other = task.settings;
  other.method = Method::hybrid;
  Result<Plan> hybrid = make_plan(*task.scene, other, execution);
  if (!hybrid) return hybrid.error();
  const PhotonMaps& pilot = *task.guide->pilot;
  RadianceSettings paths = radiance_settings(task, 0, &pilot);
  paths.technique = hybrid->uses_maps ? Technique::merge : Technique::trace;
  const float aspect = static_cast<float>(task.settings.width) / static_cast<float>(task.settings.height);
  const auto of_pass = static_cast<double>(pilot_share(task.photons));
  const double shoot = static_cast<double>(pilot.rays) / of_pass;
  const double shoot_caustic = hybrid->uses_maps ? static_cast<double>(pilot.caustic_rays) / of_pass : 0;
  const double pixels = static_cast<double>(task.settings.width) * task.settings.height;
  const double gathers = kRaysOfGather * pixels;
  const double others = hybrid->uses_maps ? gathers : kRaysOfPath * pixels;
  double ratio = 0;
  for (const std::uint32_t count : {kFewPilotPaths, kManyPilotPaths}) {
    const PilotNoise noise = measure_noise(*task.scene, task.camera, aspect, paths, *task.guide, count, execution);
    if (execution.cancelled()) return cancelled();
    const double by_photons = noise.photons * (shoot + gathers);
    const double by_paths = noise.paths * (shoot_caustic + others);
    ratio = by_photons > 0 ? by_photons / by_paths : 0;   // infinite where paths leave no noise at all
    if (!(ratio > kDoubt)) break;
  }
  char text[160] = "a pilot found no noise";
  if (ratio > 0) {
    std::snprintf(text, sizeof text, "in a pilot photons leave %.2g times the noise of paths in equal time", ratio);
  }
  if (ratio > kDoubt) {
    task.plan = *std::move(hybrid);
    task.plan.items.front().reason = std::string("hybrid: photons are sparse in the picture; ") + text;
  } else {
    task.plan.items.front().reason += std::string("; ") + text;
  }
  return Done{};
}

}  // namespace

Result<RenderTask> make_render_task(std::shared_ptr<const PreparedScene> scene, const Camera& camera,
                                    const PhotonSettings& photons, const RenderSettings& settings,
                                    const Execution& execution, const GuideSource& guides) {
  Camera moved = camera;
  moved.to_world[3] -= scene->scene.origin;
  StopRule any;
  any.passes = 1;
  if (Status status = check_settings(photons, settings, any); !status) return status.error();
  Result<Plan> plan = make_plan(*scene, settings, execution);
  if (!plan) return plan.error();
  RenderTask task{std::move(scene), std::move(moved), photons, settings, std::move(plan).value(), nullptr, {}};
  if (has_followed_volumes(task.scene->scene)) {
    task.start = enclosing(task.scene->scene, task.scene->accel, Vec3(task.camera.to_world[3]));
  }
  if (task.plan.uses_maps) {
    auto guide = guides(*task.scene, guide_key(task.scene->digest, photons), execution);
    if (!guide) return guide.error();
    task.guide = std::move(guide).value();
    if (settings.method == Method::automatic) {
      if (const Status chosen = choose_by_pilot(task, execution); !chosen) return chosen.error();
    }
    if (!task.plan.uses_maps) {
      task.guide = nullptr;
      return task;
    }
    if (task.plan.method != Method::photon_map) {
      task.plan.radius = settings.radius;
      task.plan.items.push_back(radius_item(task));
    }
    task.plan.items.push_back(edges_item(*task.guide));
  }
  return task;
}

MapKey map_key(const Digest& scene, const PhotonSettings& photons, Method method, std::uint32_t pass) {
  if (method == Method::photon_map) return irradiance_key(scene, photons);
  return {scene, photons, pass, method == Method::hybrid ? PhotonSet::caustic : PhotonSet::all};
}

Result<PassImage> render_pass(const RenderTask& task, std::uint32_t pass, const MapSource& maps,
                              const Execution& execution) {
  std::shared_ptr<const PhotonMaps> pass_maps;
  if (task.plan.uses_maps) {
    auto found = maps(map_key(task.scene->digest, task.photons, task.plan.method, pass), execution);
    if (!found) return found.error();
    pass_maps = std::move(found).value();
  }
  const RadianceSettings settings = radiance_settings(task, pass, pass_maps.get());
  const int width = task.settings.width;
  const int height = task.settings.height;
  PassImage image{.radiance = Image(width, height)};
  if (settings.technique == Technique::density || settings.technique == Technique::merge) image.bands.resize(image.radiance.pixels.size());
  std::atomic<std::uint64_t> truncated{0};
  const std::size_t pixels = image.radiance.pixels.size();
  const std::size_t together = samples_together(pixels);
  parallel_for(execution, (pixels + together - 1) / together, 1, [&](std::size_t block) {
    const std::size_t first = block * together;
    const std::size_t count = std::min(together, pixels - first);
    std::array<Ray, kMostSamplesTogether> rays;
    std::array<CameraSampler, kMostSamplesTogether> samplers;
    std::array<RadianceSample, kMostSamplesTogether> samples;
    film_rays(task.camera, {width, height, task.settings.seed, pass, first}, std::span(rays).first(count),
              std::span(samplers).first(count));
    estimate_incoming(*task.scene, settings, std::span(rays).first(count), std::span(samplers).first(count),
                      std::span(samples).first(count),
                      image.bands.empty() ? std::span<Bands>() : std::span(image.bands).subspan(first, count));
    for (std::size_t i = 0; i < count; ++i) {
      image.radiance.pixels[first + i] = samples[i].radiance;
      if (samples[i].truncated) truncated.fetch_add(1, std::memory_order_relaxed);
    }
  });
  if (execution.cancelled()) return cancelled();
  image.truncated = truncated;
  return image;
}

}  // namespace photond
