#include "server/api/job_message.h"

#include <algorithm>
#include <cmath>

#include "server/api/problem.h"
#include "server/jobs/job.h"

namespace photond {

namespace {

Json vector_json(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }

Json camera_json(const CameraChoice& choice) {
  if (const auto* index = std::get_if<std::uint32_t>(&choice)) return *index;
  if (const auto* name = std::get_if<std::string>(&choice)) return *name;
  const LookAt& placed = std::get<LookAt>(choice);
  return {{"eye", vector_json(placed.eye)},
          {"target", vector_json(placed.target)},
          {"up", vector_json(placed.up)},
          {"yfov_deg", placed.yfov_deg}};
}

Json stop_json(const StopRule& stop) {
  Json json = Json::object();
  if (stop.passes) json["passes"] = *stop.passes;
  if (stop.seconds) json["seconds"] = *stop.seconds;
  if (stop.relative_error) json["relative_error"] = *stop.relative_error;
  return json;
}

Json error_json(const std::optional<ErrorEstimate>& error) { return error ? error_message(*error) : Json(nullptr); }

Json maps_json(const JobNumbers& job) {
  return {{"hits", job.map_hits}, {"disk_hits", job.map_disk_hits}, {"misses", job.map_misses}};
}

Json failure_json(const std::optional<Error>& failure) {
  if (!failure) return nullptr;
  return {{"code", error_name(failure->code)}, {"detail", failure->message}, {"pointer", failure->where}};
}

Json pause_reason_json(PauseReason reason) {
  switch (reason) {
    case PauseReason::none:
      return nullptr;
    case PauseReason::request:
      return "request";
    case PauseReason::disk_full:
      return "disk_full";
    case PauseReason::disk_unreachable:
      return "disk_unreachable";
  }
  return nullptr;
}

Json urls_json(const JobRecord& job) {
  const std::string self = "/v1/jobs/" + job.id;
  return {{"self", self},
          {"events", self + "/events"},
          {"frame", job.revision > 0 ? Json(self + "/frames/" + std::to_string(job.revision)) : Json(nullptr)},
          {"latest", self + "/frames/latest"},
          {"series", self + "/series"},
          {"cancel", self + "/cancel"}};
}

Json time_json(const std::optional<WallTime>& time) { return time ? Json(time_text(*time)) : Json(nullptr); }

Json environment_json(const std::optional<EnvironmentChoice>& choice) {
  if (!choice) return nullptr;
  return {{"id", to_hex(choice->id)}, {"rotation_deg", choice->rotation_deg}, {"scale", choice->scale}};
}

}  // namespace

Json spec_message(const JobSpec& spec) {
  return {{"scene", to_hex(spec.scene)},
          {"environment", environment_json(spec.environment)},
          {"camera", camera_json(spec.camera)},
          {"film", {{"width", spec.settings.width}, {"height", spec.settings.height}}},
          {"method", method_name(spec.settings.method)},
          {"photons_per_pass", spec.photons.photons_per_pass},
          {"radius", spec.settings.radius},
          {"gather_photons", spec.settings.gather_photons},
          {"seed", spec.settings.seed},
          {"stop", stop_json(spec.stop)},
          {"priority", spec.priority == Priority::batch ? "batch" : "interactive"},
          {"label", spec.label}};
}

Json error_message(const ErrorEstimate& error) {
  if (!error.known || !std::isfinite(error.rmse) || !std::isfinite(error.relative)) return nullptr;
  return {{"relative", error.relative}, {"noise", error.noise}, {"bias", error.bias}, {"rmse", error.rmse}};
}

Json plan_message(const Plan& plan) {
  Json items = Json::array();
  for (const PlanItem& item : plan.items) {
    items.push_back({{"feature", item.feature}, {"active", item.active}, {"reason", item.reason}});
  }
  return {{"method", method_name(plan.method)},
          {"biased", plan.biased},
          {"uses_maps", plan.uses_maps},
          {"radius", plan.radius},
          {"items", std::move(items)}};
}

Json job_message(const JobRecord& job) {
  return {{"id", job.id},
          {"state", state_name(job.state)},
          {"version", job.version},
          {"label", job.spec.label},
          {"scene", to_hex(job.spec.scene)},
          {"spec", spec_message(job.spec)},
          {"created_at", time_text(job.created)},
          {"started_at", time_json(job.started)},
          {"finished_at", time_json(job.finished)},
          {"plan", job.plan ? plan_message(*job.plan) : Json(nullptr)},
          {"maps", maps_json(job)},
          {"passes", job.passes},
          {"seconds", job.seconds},
          {"rejected_samples", job.rejected},
          {"error", error_json(job.error)},
          {"eta_seconds", optional_json(job.eta_seconds)},
          {"revision", job.revision},
          {"first_frame_seconds", optional_json(job.first_frame_seconds)},
          {"paused_because", pause_reason_json(job.pause_reason)},
          {"problem", failure_json(job.failure)},
          {"urls", urls_json(job)}};
}

Json event_message(const Event& event) {
  return {{"job", event.job},
          {"time", time_text(event.time)},
          {"state", state_name(event.state)},
          {"version", event.version},
          {"passes", event.passes},
          {"seconds", event.seconds},
          {"rejected_samples", event.rejected},
          {"error", error_json(event.error)},
          {"eta_seconds", optional_json(event.eta_seconds)},
          {"maps", maps_json(event)},
          {"revision", event.revision}};
}

namespace {

/// Without what a job had done beyond the checkpoint from which it went on: passes and seconds only grow.
std::vector<SeriesPoint> growing(const JobRecord& job) {
  std::vector<SeriesPoint> points;
  for (auto point = job.series.rbegin(); point != job.series.rend(); ++point) {
    const bool before = points.empty() ? point->passes <= job.passes
                                       : point->passes < points.back().passes && point->seconds < points.back().seconds;
    if (before) points.push_back(*point);
  }
  std::reverse(points.begin(), points.end());
  return points;
}

}  // namespace

Json series_message(const JobRecord& job) {
  Json points = Json::array();
  for (const SeriesPoint& point : growing(job)) {
    points.push_back({{"revision", point.revision},
                      {"passes", point.passes},
                      {"seconds", point.seconds},
                      {"error", error_json(point.error)}});
  }
  return {{"job", job.id}, {"points", std::move(points)}};
}

const char* event_name(EventKind kind) {
  switch (kind) {
    case EventKind::state:
      return "state";
    case EventKind::progress:
      return "progress";
    case EventKind::frame:
      return "frame";
    case EventKind::gone:
      return "gone";
  }
  return "state";
}

}  // namespace photond
