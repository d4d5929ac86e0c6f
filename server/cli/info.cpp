#include <iomanip>
#include <iostream>
#include <sstream>

#include "core/render/plan.h"
#include "server/cli/cli.h"
#include "server/cli/commands.h"
#include "server/cli/load_scene.h"
#include "server/cli/printable.h"
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

std::string quoted(const std::string& name) { return name.empty() ? "(unnamed)" : "'" + printable(name) + "'"; }

void print_counts(std::ostream& out, const SceneReport& report) {
  field(out, "triangles") << report.triangles_placed << " in " << report.instances << " instances of "
                          << report.meshes << " meshes (" << report.triangles_stored << " stored, "
                          << report.emissive_triangles << " emit light)\n";
  field(out, "textures") << report.textures << " (" << report.texture_pixels << " pixels)\n";
  field(out, "bounds") << text_of(report.bounds.min) << " to " << text_of(report.bounds.max) << " m\n";
}

void print_cameras(std::ostream& out, const std::vector<Camera>& cameras) {
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    field(out, i == 0 ? "cameras" : "")
        << i << " " << quoted(cameras[i].name) << (cameras[i].orthographic ? " orthographic" : " perspective")
        << " at " << text_of(cameras[i].to_world[3]) << "\n";
  }
}

void print_lights(std::ostream& out, const SceneReport& report, const Environment& environment) {
  for (const SceneReport::LightEntry& light : report.lights) {
    field(out, "light") << quoted(light.name) << " " << light_type_name(light.type) << " "
                        << text_of(light.intensity) << "\n";
  }
  if (environment.map != nullptr) {
    field(out, "environment") << text_of(report.environment) << " times a map of " << environment.map->width() << "x"
                              << environment.map->height() << " pixels, turned by "
                              << glm::degrees(environment.rotation) << " degrees\n";
  } else if (environment.active()) {
    field(out, "environment") << text_of(report.environment) << "\n";
  }
}

void print_materials(std::ostream& out, const SceneReport& report) {
  for (const SceneReport::MaterialEntry& material : report.materials) {
    field(out, "material") << quoted(material.name) << " " << material.kind
                           << (material.emissive ? ", emissive" : "") << (material.textured ? ", textured" : "")
                           << "\n";
  }
}

void print_plan(std::ostream& out, const Plan& plan) {
  field(out, "method") << method_name(plan.method) << (plan.biased ? " (biased)" : "") << "\n";
  for (const PlanItem& item : plan.items) {
    out << "  " << (item.active ? "+ " : "- ") << item.feature << ": " << item.reason << "\n";
  }
}

void print_info(std::ostream& out, const std::string& file, const PreparedScene& prepared,
                const SceneSummary& summary) {
  const SceneReport& report = summary.report;
  out << file << "\n";
  field(out, "digest") << to_hex(prepared.digest) << "\n";
  print_counts(out, report);
  field(out, "memory") << (prepared.memory_bytes >> 10) << " KiB\n";
  print_cameras(out, summary.cameras);
  print_lights(out, report, prepared.scene.environment);
  print_materials(out, report);
  print_plan(out, summary.plan);
  for (const std::string& warning : report.warnings) out << "  warning: " << printable(warning) << "\n";
}

}  // namespace

int run_info(const InfoCommand& command) {
  const Workers workers;
  auto scene = load_scene(command.scene, command.environment);
  if (!scene) return print_failure(command.scene, scene.error());
  const auto prepared = prepare(*std::move(scene), workers.execution());
  if (!prepared) return print_failure(command.scene, prepared.error());
  const auto plan = make_plan(**prepared, RenderSettings{}, workers.execution());
  if (!plan) return print_failure(command.scene, plan.error());
  const SceneSummary summary = summarize(**prepared, *plan);
  if (command.json)
    std::cout << indented(info_json(command.scene, **prepared, summary));
  else
    print_info(std::cout, command.scene, **prepared, summary);
  return finish_output();
}

}  // namespace photond
