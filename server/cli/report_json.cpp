#include "server/cli/report_json.h"

#include "core/film/error.h"
#include "server/api/job_message.h"
#include "server/api/scene_message.h"

namespace photond {
namespace {

Json stop_json(const StopRule& stop) {
  Json result = Json::object();
  if (stop.passes) result["passes"] = *stop.passes;
  if (stop.seconds) result["seconds"] = *stop.seconds;
  if (stop.relative_error) result["relative_error"] = *stop.relative_error;
  return result;
}

Json settings_json(const RenderTask& task, const StopRule& stop) {
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

Json maps_json(const MapStatistics& maps) {
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

Json error_json(const ErrorEstimate& error) {
  if (!error.known) return nullptr;
  return {{"rmse", error.rmse}, {"relative", error.relative}};
}

Json series_json(const std::vector<Progress>& series) {
  Json points = Json::array();
  for (const Progress& p : series) {
    points.push_back({{"seconds", p.seconds},
                      {"passes", p.passes},
                      {"relative_error", p.error.known ? Json(p.error.relative) : Json(nullptr)}});
  }
  return points;
}

}  // namespace

SceneSummary summarize(const PreparedScene& prepared, const Plan& plan) {
  return {.report = make_report(prepared.scene), .cameras = prepared.scene.cameras, .plan = plan};
}

Json info_json(const std::string& file, const PreparedScene& prepared, const SceneSummary& summary) {
  Json result = {{"file", file}, {"digest", to_hex(prepared.digest)}, {"memory_bytes", prepared.memory_bytes}};
  result.update(report_message(summary));
  result["plan"] = plan_message(summary.plan);
  return result;
}

Json render_json(const RenderCommand& command, const StopRule& stop, const RenderTask& task,
                 const Rendering& rendering, const StageSeconds& seconds) {
  return {{"photond", PHOTOND_VERSION},
          {"scene", info_json(command.scene, *task.scene, summarize(*task.scene, task.plan))},
          {"camera", task.camera.name},
          {"settings", settings_json(task, stop)},
          {"outputs", command.outputs},
          {"passes", rendering.film.pass_count()},
          {"rejected_samples", rendering.film.rejected},
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

std::string indented(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace photond
