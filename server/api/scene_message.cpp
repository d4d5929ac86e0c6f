#include "server/api/scene_message.h"

#include "server/api/job_message.h"

namespace photond {

namespace {

Json triple(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }

Json counts_of(const SceneReport& report) {
  return {{"meshes", report.meshes},
          {"triangles", report.triangles_placed},
          {"triangles_stored", report.triangles_stored},
          {"emissive_triangles", report.emissive_triangles},
          {"instances", report.instances},
          {"textures", report.textures},
          {"texture_pixels", report.texture_pixels}};
}

Json bounds_of(const Bounds3& bounds) {
  if (bounds.empty()) return nullptr;
  return {{"min", triple(bounds.min)}, {"max", triple(bounds.max)}};
}

Json cameras_of(const std::vector<Camera>& cameras) {
  Json list = Json::array();
  for (const Camera& camera : cameras) {
    list.push_back({{"name", camera.name},
                    {"orthographic", camera.orthographic},
                    {"yfov_deg", camera.orthographic ? Json(nullptr) : Json(glm::degrees(camera.yfov))},
                    {"eye", triple(camera.to_world[3])},
                    {"direction", triple(-camera.to_world[2])},
                    {"up", triple(camera.to_world[1])}});
  }
  return list;
}

Json lights_of(const SceneReport& report) {
  Json list = Json::array();
  for (const SceneReport::LightEntry& light : report.lights) {
    list.push_back(
        {{"name", light.name}, {"type", light_type_name(light.type)}, {"intensity", triple(light.intensity)}});
  }
  return list;
}

Json materials_of(const SceneReport& report) {
  Json list = Json::array();
  for (const SceneReport::MaterialEntry& material : report.materials) {
    list.push_back({{"name", material.name},
                    {"kind", material.kind},
                    {"emissive", material.emissive},
                    {"textured", material.textured}});
  }
  return list;
}

}  // namespace

Json report_message(const SceneSummary& summary) {
  const SceneReport& report = summary.report;
  return {{"counts", counts_of(report)},
          {"bounds", bounds_of(report.bounds)},
          {"environment", triple(report.environment)},
          {"cameras", cameras_of(summary.cameras)},
          {"lights", lights_of(report)},
          {"materials", materials_of(report)},
          {"warnings", report.warnings}};
}

Json scene_message(const SceneRecord& scene, const SceneSummary* summary) {
  const std::string self = "/v1/scenes/" + to_hex(scene.id);
  const bool glb = scene.media_type == "model/gltf-binary";
  Json message{{"id", to_hex(scene.id)},
               {"name", scene.name},
               {"sample", scene.sample},
               {"media_type", scene.media_type},
               {"bytes", scene.bytes},
               {"created_at", time_text(scene.created)},
               {"urls", {{"self", self}, {"glb", glb ? Json(self + ".glb") : Json(nullptr)}}}};
  if (summary != nullptr) {
    message["report"] = report_message(*summary);
    message["plan"] = plan_message(summary->plan);
  }
  return message;
}

}  // namespace photond
