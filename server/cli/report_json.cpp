#include "server/cli/report_json.h"

#include <cmath>

#include "core/film/film.h"

namespace photond {
namespace {

using nlohmann::json;

json vector_json(const Vec3& v) { return {v.x, v.y, v.z}; }

json bounds_json(const Bounds3& bounds) {
  if (bounds.empty()) return nullptr;
  return {{"min", vector_json(bounds.min)}, {"max", vector_json(bounds.max)}};
}

json camera_json(const Camera& camera) {
  json result = {{"name", camera.name},
                 {"type", camera.orthographic ? "orthographic" : "perspective"},
                 {"eye", vector_json(camera.to_world[3])},
                 {"direction", vector_json(-camera.to_world[2])}};
  if (camera.orthographic) result["ymag"] = camera.ymag;
  else result["yfov_deg"] = glm::degrees(camera.yfov);
  return result;
}

json light_json(const PunctualLight& light) {
  static constexpr const char* kTypes[] = {"point", "spot", "directional"};
  return {{"name", light.name},
          {"type", kTypes[static_cast<int>(light.type)]},
          {"intensity", vector_json(light.intensity)}};
}

json material_json(const Material& material) {
  json features = json::array();
  if (material.emissive()) features.push_back("emissive");
  if (material.metallic > 0) features.push_back("metallic");
  if (material.transmission > 0) features.push_back("transmission");
  if (!material.thin_walled) features.push_back("volume");
  if (std::isfinite(material.attenuation_distance)) features.push_back("absorption");
  if (material.alpha_mode == AlphaMode::mask) features.push_back("alpha_mask");
  if (material.alpha_mode == AlphaMode::blend) features.push_back("alpha_blend");
  if (material.double_sided) features.push_back("double_sided");
  return {{"name", material.name}, {"roughness", material.roughness}, {"features", features}};
}

template <class T, class F>
json list_json(const std::vector<T>& values, const F& convert) {
  json list = json::array();
  for (const T& value : values) list.push_back(convert(value));
  return list;
}

std::uint64_t emissive_triangles(const Scene& scene) {
  std::uint64_t count = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (scene.materials[mesh.material].emissive()) count += mesh.triangles.size();
  }
  return count;
}

json counts_json(const PreparedScene& prepared) {
  const Scene& scene = prepared.scene;
  std::uint64_t vertices = 0;
  for (const Mesh& mesh : scene.meshes) vertices += mesh.positions.size();
  return {{"triangles", prepared.triangle_count},
          {"emissive_triangles", emissive_triangles(scene)},
          {"vertices", vertices},
          {"meshes", scene.meshes.size()},
          {"instances", scene.instances.size()},
          {"materials", scene.materials.size()},
          {"textures", scene.textures.size()},
          {"images", scene.images.size()},
          {"punctual_lights", scene.lights.size()},
          {"cameras", scene.cameras.size()}};
}

json stop_json(const StopRule& stop) {
  json result = json::object();
  if (stop.passes) result["passes"] = *stop.passes;
  if (stop.seconds) result["seconds"] = *stop.seconds;
  if (stop.relative_error) result["relative_error"] = *stop.relative_error;
  return result;
}

json settings_json(const RenderTask& task, const StopRule& stop) {
  const RenderSettings& s = task.settings;
  return {{"method", method_name(s.method)},
          {"width", s.width},
          {"height", s.height},
          {"seed", s.seed},
          {"radius", s.radius},
          {"gather_photons", s.gather_photons},
          {"max_depth", s.max_depth},
          {"photons_per_pass", task.photons.photons_per_pass},
          {"stop", stop_json(stop)}};
}

json maps_json(const MapStatistics& maps) {
  return {{"built", maps.built},
          {"emitted_paths", maps.emitted},
          {"photons_stored", {{"global", maps.global_photons}, {"caustic", maps.caustic_photons}}},
          {"rays", maps.rays},
          {"largest_bytes", maps.largest_bytes},
          {"energy",
           {{"emitted", maps.ledger.emitted},
            {"absorbed", maps.ledger.absorbed},
            {"escaped", maps.ledger.escaped},
            {"truncated", maps.ledger.truncated},
            {"rejected", maps.ledger.rejected}}}};
}

json error_json(const ErrorEstimate& error) {
  if (!error.known) return nullptr;
  return {{"rmse", error.rmse}, {"relative", error.relative}};
}

json series_json(const std::vector<Progress>& series) {
  return list_json(series, [](const Progress& p) -> json {
    return {{"seconds", p.seconds},
            {"passes", p.passes},
            {"relative_error", p.error.known ? json(p.error.relative) : json(nullptr)}};
  });
}

}  // namespace

json plan_json(const Plan& plan) {
  return {{"method", method_name(plan.method)},
          {"biased", plan.biased},
          {"uses_maps", plan.uses_maps},
          {"radius", plan.radius},
          {"items", list_json(plan.items, [](const PlanItem& item) -> json {
             return {{"feature", item.feature}, {"active", item.active}, {"reason", item.reason}};
           })}};
}

json scene_json(const PreparedScene& prepared) {
  const Scene& scene = prepared.scene;
  return {{"digest", to_hex(prepared.digest)},
          {"counts", counts_json(prepared)},
          {"memory_bytes", prepared.memory_bytes},
          {"bounds", bounds_json(prepared.bounds)},
          {"cameras", list_json(scene.cameras, camera_json)},
          {"lights", list_json(scene.lights, light_json)},
          {"environment", vector_json(scene.environment.radiance)},
          {"total_power", prepared.lights.total_power()},
          {"materials", list_json(scene.materials, material_json)},
          {"warnings", scene.warnings}};
}

json render_json(const RenderCommand& command, const StopRule& stop, const RenderTask& task,
                 const Rendering& rendering, const StageSeconds& seconds) {
  json scene = scene_json(*task.scene);
  scene["file"] = command.scene;
  return {{"photond", PHOTOND_VERSION},
          {"scene", scene},
          {"camera", camera_json(task.camera)},
          {"plan", plan_json(task.plan)},
          {"settings", settings_json(task, stop)},
          {"outputs", command.outputs},
          {"passes", rendering.film.passes},
          {"stopped_by", rendering.stopped_by},
          {"seconds",
           {{"load", seconds.load},
            {"prepare", seconds.prepare},
            {"plan", seconds.plan},
            {"maps", rendering.maps.seconds},
            {"render", rendering.seconds},
            {"encode", seconds.encode}}},
          {"maps", maps_json(rendering.maps)},
          {"error", error_json(estimate_error(rendering.film))},
          {"series", series_json(rendering.series)}};
}

std::string json_text(const json& value) {
  return value.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace photond
