#include <iomanip>
#include <iostream>
#include <sstream>

#include "core/render/plan.h"
#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/load_scene.h"
#include "server/cli/report_json.h"

namespace photond {
namespace {

std::ostream& field(std::ostream& out, const std::string& name) {
  return out << "  " << std::left << std::setw(14) << name;
}

std::string text_of(const Vec3& v) {
  std::ostringstream out;
  out << "(" << v.x << ", " << v.y << ", " << v.z << ")";
  return out.str();
}

std::string quoted(const std::string& name) { return name.empty() ? "(unnamed)" : "'" + name + "'"; }

void print_counts(std::ostream& out, const nlohmann::json& counts) {
  for (const auto& [name, count] : counts.items()) {
    std::string label = name;
    std::replace(label.begin(), label.end(), '_', ' ');
    field(out, "") << std::right << std::setw(12) << count.get<std::uint64_t>() << " " << label << "\n";
  }
}

void print_cameras(std::ostream& out, const Scene& scene) {
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
    const Camera& camera = scene.cameras[i];
    field(out, i == 0 ? "cameras" : "")
        << i << " " << quoted(camera.name) << (camera.orthographic ? " orthographic" : " perspective") << " at "
        << text_of(camera.to_world[3]) << "\n";
  }
}

void print_lights(std::ostream& out, const Scene& scene) {
  static constexpr const char* kTypes[] = {"point", "spot", "directional"};
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const PunctualLight& light = scene.lights[i];
    field(out, i == 0 ? "lights" : "") << kTypes[static_cast<int>(light.type)] << " " << quoted(light.name) << " "
                                       << text_of(light.intensity) << "\n";
  }
  if (scene.environment.active()) field(out, "environment") << text_of(scene.environment.radiance) << "\n";
}

void print_materials(std::ostream& out, const nlohmann::json& materials) {
  bool first = true;
  for (const auto& material : materials) {
    field(out, first ? "materials" : "") << quoted(material["name"].get<std::string>());
    for (const auto& feature : material["features"]) out << " " << feature.get<std::string>();
    out << "\n";
    first = false;
  }
}

void print_plan(std::ostream& out, const Plan& plan) {
  field(out, "method") << method_name(plan.method) << (plan.biased ? " (biased)" : "") << "\n";
  if (plan.uses_maps) field(out, "radius") << plan.radius << " m\n";
  for (const PlanItem& item : plan.items) {
    out << "  " << (item.active ? "+ " : "- ") << item.feature << ": " << item.reason << "\n";
  }
}

void print_info(std::ostream& out, const std::string& file, const PreparedScene& prepared, const Plan& plan) {
  const Scene& scene = prepared.scene;
  const nlohmann::json json = scene_json(prepared);
  out << file << "\n";
  field(out, "digest") << to_hex(prepared.digest) << "\n";
  print_counts(out, json["counts"]);
  field(out, "bounds") << text_of(prepared.bounds.min) << " to " << text_of(prepared.bounds.max) << " m\n";
  field(out, "memory") << (prepared.memory_bytes >> 20) << " MiB\n";
  print_cameras(out, scene);
  print_lights(out, scene);
  print_materials(out, json["materials"]);
  print_plan(out, plan);
  for (const std::string& warning : scene.warnings) out << "  warning: " << warning << "\n";
}

}  // namespace

int run_info(const InfoCommand& command) {
  const Workers workers;
  auto scene = load_scene(command.scene);
  if (!scene) return print_failure(command.scene, scene.error());
  const auto prepared = prepare(*std::move(scene), workers.execution());
  if (!prepared) return print_failure(command.scene, prepared.error());
  const auto plan = make_plan(**prepared, PhotonSettings{}, RenderSettings{}, workers.execution());
  if (!plan) return print_failure(command.scene, plan.error());
  if (command.json) {
    nlohmann::json json = scene_json(**prepared);
    json["file"] = command.scene;
    json["plan"] = plan_json(*plan);
    std::cout << json_text(json);
  } else {
    print_info(std::cout, command.scene, **prepared, *plan);
  }
  return kExitOk;
}

}  // namespace photond
