#include "core/render/render.h"

#include <cmath>
#include <cstdio>

#include "core/photon/radius.h"
#include "core/render/pilot.h"
#include "core/render/radiance.h"

namespace photond {

namespace {

std::string radius_reason(const RenderSettings& settings, float radius) {
  char text[96];
  std::snprintf(text, sizeof text, "first radius %.4g m, %s; shrinks with every pass", static_cast<double>(radius),
                settings.radius > 0 ? "as asked" : "from a pilot map and the pixels' footprints");
  return text;
}

RadianceSettings radiance_settings(const RenderTask& task, std::uint32_t pass, const PhotonMaps* maps) {
  RadianceSettings settings;
  settings.maps = maps;
  settings.nearest = task.settings.gather_photons;
  settings.max_depth = task.settings.max_depth;
  if (task.plan.method == Method::progressive) {
    settings.technique = Technique::density;
    const double radius_sq = static_cast<double>(task.plan.radius) * task.plan.radius;
    settings.radius_sq = static_cast<float>(radius_sq * radius_sq_factor(pass));
  } else if (task.plan.method == Method::photon_map) {
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
  StopRule any;
  any.passes = 1;
  if (Status status = check_settings(photons, settings, any); !status) return status.error();
  Result<Plan> plan = make_plan(*scene, settings, execution);
  if (!plan) return plan.error();
  if (plan->method == Method::progressive) {
    plan->radius = settings.radius;
    if (settings.radius == 0) {
      const Result<float> radius = pilot_radius(*scene, camera, photons, settings, execution);
      if (!radius) return radius.error();
      plan->radius = *radius;
    }
    plan->items.push_back({"radius", true, radius_reason(settings, plan->radius)});
  }
  return RenderTask{std::move(scene), camera, photons, settings, std::move(plan).value()};
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
  PassImage image{.radiance = Image(width, height), .bias = {}};
  parallel_for(execution, image.radiance.pixels.size(), 256, [&](std::size_t i) {
    Rng rng(task.settings.seed, RngPurpose::camera, pass, i);
    const Vec2 jitter = rng.next2();
    const auto x = static_cast<float>(i % static_cast<std::size_t>(width));
    const auto y = static_cast<float>(i / static_cast<std::size_t>(width));
    const Vec2 film{(x + jitter.x) / static_cast<float>(width), (y + jitter.y) / static_cast<float>(height)};
    image.radiance.pixels[i] = estimate_incoming(*task.scene, settings, camera_ray(task.camera, film, aspect), rng);
  });
  if (execution.cancelled()) return cancelled();
  return image;
}

}  // namespace photond
