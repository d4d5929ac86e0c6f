#include "core/render/render.h"

#include <atomic>
#include <cmath>
#include <cstdio>

#include "core/photon/radius.h"
#include "core/render/radiance.h"

namespace photond {

namespace {

PlanItem radius_item(const RenderSettings& settings) {
  char text[96];
  std::snprintf(text, sizeof text, "widest radius %.4g m in the first pass, as asked",
                static_cast<double>(settings.radius));
  return {"radius", true,
          settings.radius > 0 ? text : "chosen for each gather from a pilot map's density and the pixel's footprint"};
}

PlanItem edges_item(const GatherGuide& guide) {
  const std::string count = std::to_string(guide.edges.size());
  return {"edges", guide.edges.size() > 0,
          guide.edges.size() > 0 ? "kernels end at " + count + " open or sharp edges" : "no surface ends or bends sharply"};
}

RadianceSettings radiance_settings(const RenderTask& task, std::uint32_t pass, const PhotonMaps* maps) {
  RadianceSettings settings;
  settings.maps = maps;
  settings.guide = task.guide.get();
  settings.nearest = task.settings.gather_photons;
  settings.max_depth = task.settings.max_depth;
  if (!task.plan.uses_maps) return settings;
  if (task.plan.method != Method::photon_map) {
    settings.technique = task.plan.method == Method::hybrid ? Technique::merge : Technique::density;
    settings.shrink = static_cast<float>(radius_sq_factor(pass));
    settings.radius_sq = task.settings.radius * task.settings.radius * settings.shrink;
    (task.camera.orthographic ? settings.pixel_width : settings.pixel_spread) =
        pixel_spread(task.camera, task.settings.height);
  } else {
    settings.technique = Technique::final_gather;
    // The k-nearest search ends somewhere even where hardly a photon falls.
    const float reach = task.settings.radius > 0 ? task.settings.radius : 0.1f * task.scene->bounds.radius();
    settings.radius_sq = reach * reach;
  }
  return settings;
}

}  // namespace

Result<RenderTask> make_render_task(std::shared_ptr<const PreparedScene> scene, const Camera& camera,
                                    const PhotonSettings& photons, const RenderSettings& settings,
                                    const Execution& execution) {
  Camera moved = camera;
  moved.to_world[3] -= scene->scene.origin;
  StopRule any;
  any.passes = 1;
  if (Status status = check_settings(photons, settings, any); !status) return status.error();
  Result<Plan> plan = make_plan(*scene, settings, execution);
  if (!plan) return plan.error();
  RenderTask task{std::move(scene), std::move(moved), photons, settings, std::move(plan).value(), nullptr};
  if (task.plan.uses_maps) {
    auto guide = make_gather_guide(*task.scene, photons, execution);
    if (!guide) return guide.error();
    task.guide = std::move(guide).value();
    if (task.plan.method != Method::photon_map) {
      task.plan.radius = settings.radius;
      task.plan.items.push_back(radius_item(settings));
    }
    task.plan.items.push_back(edges_item(*task.guide));
  }
  return task;
}

Result<PassImage> render_pass(const RenderTask& task, std::uint32_t pass, const MapSource& maps,
                              const Execution& execution) {
  std::shared_ptr<const PhotonMaps> pass_maps;
  if (task.plan.uses_maps) {
    const std::uint32_t map_pass = task.plan.method == Method::photon_map ? 0 : pass;
    auto found = maps({task.scene->digest, task.photons, map_pass}, execution);
    if (!found) return found.error();
    pass_maps = std::move(found).value();
  }
  const RadianceSettings settings = radiance_settings(task, pass, pass_maps.get());
  const int width = task.settings.width;
  const int height = task.settings.height;
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  PassImage image{.radiance = Image(width, height)};
  if (settings.technique == Technique::density || settings.technique == Technique::merge) image.bands.resize(image.radiance.pixels.size());
  std::atomic<std::uint64_t> truncated{0};
  parallel_for(execution, image.radiance.pixels.size(), 256, [&](std::size_t i) {
    CameraSampler sampler(task.settings.seed, pass, i);
    const Vec2 jitter = sampler.next2();
    const auto x = static_cast<float>(i % static_cast<std::size_t>(width));
    const auto y = static_cast<float>(i / static_cast<std::size_t>(width));
    const Vec2 film{(x + jitter.x) / static_cast<float>(width), (y + jitter.y) / static_cast<float>(height)};
    const RadianceSample sample =
        estimate_incoming(*task.scene, settings, camera_ray(task.camera, film, aspect), sampler);
    image.radiance.pixels[i] = sample.radiance;
    if (sample.truncated) truncated.fetch_add(1, std::memory_order_relaxed);
    if (!image.bands.empty()) image.bands[i] = sample.bands;
  });
  if (execution.cancelled()) return cancelled();
  image.truncated = truncated;
  return image;
}

}  // namespace photond
