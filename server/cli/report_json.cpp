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

Json series_json(const std::vector<MeasuredPass>& series) {
  Json points = Json::array();
  for (const MeasuredPass& point : series) {
    const ErrorEstimate& error = point.progress.error;
    Json json = {{"seconds", point.progress.seconds}, {"passes", point.progress.passes}};
    json["relative_error"] = error.known ? Json(error.relative) : Json(nullptr);
    json["noise"] = error.known ? Json(error.noise) : Json(nullptr);
    json["bias"] = error.known ? Json(error.bias) : Json(nullptr);
    if (point.rel_mse) json["rel_mse"] = *point.rel_mse;
    points.push_back(std::move(json));
  }
  return points;
}

Json reference_json(const RenderCommand& command, const Rendering& rendering) {
  if (command.reference.empty()) return nullptr;
  return {{"file", command.reference}, {"rel_mse", optional_json(rendering.series.back().rel_mse)}};
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

Json error_json(const Film& film, const ErrorEstimate& error) {
  Json json = error_message(error);
  if (json.is_object()) {
    json["dominated_pixels"] = error.dominated;
    json["few_passes"] = film.pass_count() < kReliablePasses;
  }
  return json;
}

Json render_json(const RenderCommand& command, const StopRule& stop, const RenderTask& task,
                 const Rendering& rendering, const LoadSeconds& seconds, double encode_seconds) {
  Json settings = settings_json(task);
  settings["stop"] = stop_json(stop);
  return {{"photond", PHOTOND_VERSION},
          {"scene", info_json(command.task.scene, *task.scene, summarize(*task.scene, task.plan))},
          {"camera", task.camera.name},
          {"settings", std::move(settings)},
          {"outputs", command.outputs},
          {"passes", rendering.film.pass_count()},
          {"rejected_samples", rendering.film.rejected},
          {"truncated_paths", rendering.film.truncated},
          {"stopped_by", rendering.stopped_by},
          {"seconds",
           {{"load", seconds.load},
            {"prepare", seconds.prepare},
            {"plan", seconds.plan},
            {"maps", rendering.maps.seconds},
            {"render", rendering.seconds},
            {"encode", encode_seconds}}},
          {"maps", maps_json(rendering.maps)},
          {"error", error_json(rendering.film, rendering.series.back().progress.error)},
          {"reference", reference_json(command, rendering)},
          {"series", series_json(rendering.series)}};
}

std::string indented(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace photond
