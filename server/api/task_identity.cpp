#include "server/api/task_identity.h"

#include "server/store/file.h"

namespace photond {

const Result<Digest>& running_program() {
  static const Result<Digest> digest = []() -> Result<Digest> {
    const auto program = read_whole("/proc/self/exe");
    if (!program) return program.error();
    return sha256(*program);
  }();
  return digest;
}

namespace {

Json camera_json(const Camera& camera) {
  const auto& [name, to_world, orthographic, yfov, ymag] = camera;  // all members: none can be forgotten
  Json matrix = Json::array();
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) matrix.push_back(to_world[column][row]);
  }
  return {{"name", name}, {"to_world", matrix}, {"orthographic", orthographic}, {"yfov", yfov}, {"ymag", ymag}};
}

Json decisions_json(const Plan& plan) {
  const auto& [method, biased, uses_maps, radius, items] = plan;
  Json active = Json::object();
  for (const PlanItem& item : items) active[item.feature] = item.active;
  return {{"method", method_name(method)},
          {"biased", biased},
          {"uses_maps", uses_maps},
          {"radius", radius},
          {"active", active}};
}

}  // namespace

Json settings_json(const RenderTask& task) {
  const auto& [method, width, height, seed, radius, gather_photons, max_depth] = task.settings;
  const auto& [photons_per_pass, photon_seed] = task.photons;
  return {{"method", method_name(method)},
          {"width", width},
          {"height", height},
          {"seed", seed},
          {"photon_seed", photon_seed},
          {"radius", radius},
          {"gather_photons", gather_photons},
          {"max_depth", max_depth},
          {"photons_per_pass", photons_per_pass}};
}

Result<Json> task_identity(const RenderTask& task) {
  const Result<Digest>& program = running_program();
  if (!program) return program.error();
  return Json{{"build", {{"photond", PHOTOND_VERSION}, {"program", to_hex(*program)}}},
              {"scene", to_hex(task.scene->digest)},
              {"camera", camera_json(task.camera)},
              {"settings", settings_json(task)},
              {"plan", decisions_json(task.plan)}};
}

std::string first_difference(const Json& a, const Json& b) {
  if (!a.is_object() || !b.is_object()) return {};
  const auto differs = [](const Json& x, const Json& y, const std::string& key) {
    return x.contains(key) != y.contains(key) || (x.contains(key) && x[key] != y[key]);
  };
  for (const Json* side : {&a, &b}) {
    for (const auto& item : side->items()) {
      const std::string& key = item.key();
      if (!differs(a, b, key)) continue;
      if (!a.contains(key) || !b.contains(key)) return key;
      const std::string inner = first_difference(a[key], b[key]);
      return inner.empty() ? key : key + "." + inner;
    }
  }
  return {};
}

}  // namespace photond
