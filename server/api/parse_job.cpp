#include "server/api/job_message.h"

namespace photond {

namespace {

/// Sets `to` where the message has the field; its schema has seen to the type and the range.
template <class T>
void take(const Json& fields, const char* name, T& to) {
  if (const auto found = fields.find(name); found != fields.end()) to = found->get<T>();
}
template <class T>
void take(const Json& fields, const char* name, std::optional<T>& to) {
  if (const auto found = fields.find(name); found != fields.end()) to = found->get<T>();
}
void take(const Json& fields, const char* name, Vec3& to) {
  const auto found = fields.find(name);
  if (found != fields.end()) to = {(*found)[0].get<float>(), (*found)[1].get<float>(), (*found)[2].get<float>()};
}

Result<CameraChoice> read_placement(const Json& fields) {
  LookAt placed;
  take(fields, "eye", placed.eye);
  take(fields, "target", placed.target);
  take(fields, "up", placed.up);
  take(fields, "yfov_deg", placed.yfov_deg);
  const Vec3 view = placed.target - placed.eye;
  if (!(glm::length(view) > 0)) return invalid_input("/camera/target must not be the eye", "/camera/target");
  if (!(glm::length(placed.up) > 0)) return invalid_input("/camera/up must not be zero", "/camera/up");
  const float sine = glm::length(glm::cross(glm::normalize(view), glm::normalize(placed.up)));
  if (!(sine > 1e-4f)) return invalid_input("/camera/up must not be parallel to the view", "/camera/up");
  return CameraChoice(placed);
}

Result<CameraChoice> read_camera(const Json& camera) {
  if (camera.is_object()) return read_placement(camera);
  if (camera.is_string()) return CameraChoice(camera.get<std::string>());
  return CameraChoice(camera.get<std::uint32_t>());
}

EnvironmentChoice read_environment_choice(const Json& fields) {
  EnvironmentChoice choice{*digest_from_hex(fields["id"].get<std::string>())};
  take(fields, "rotation_deg", choice.rotation_deg);
  take(fields, "scale", choice.scale);
  return choice;
}

}  // namespace

StopRule parse_stop(const Json& message) {
  const auto fields = message.find("stop");
  // An unattended job must end: a minute suffices for a first look, 256 passes for a good picture.
  if (fields == message.end()) return {.passes = 256, .seconds = 60.0, .relative_error = {}};
  StopRule stop;
  take(*fields, "passes", stop.passes);
  take(*fields, "seconds", stop.seconds);
  take(*fields, "relative_error", stop.relative_error);
  return stop;
}

Result<JobSpec> parse_job(const Json& message) {
  JobSpec spec;
  spec.scene = *digest_from_hex(message["scene"].get<std::string>());
  if (const auto environment = message.find("environment"); environment != message.end() && !environment->is_null())
    spec.environment = read_environment_choice(*environment);
  if (const auto camera = message.find("camera"); camera != message.end()) {
    Result<CameraChoice> choice = read_camera(*camera);
    if (!choice) return choice.error();
    spec.camera = std::move(*choice);
  }
  if (const auto film = message.find("film"); film != message.end()) {
    take(*film, "width", spec.settings.width);
    take(*film, "height", spec.settings.height);
  }
  if (const auto method = message.find("method"); method != message.end())
    spec.settings.method = *method_from_name(method->get<std::string>().c_str());
  spec.photons.photons_per_pass = default_photons(spec.settings);
  take(message, "photons_per_pass", spec.photons.photons_per_pass);
  take(message, "radius", spec.settings.radius);
  take(message, "gather_photons", spec.settings.gather_photons);
  take(message, "seed", spec.settings.seed);
  spec.photons.seed = spec.settings.seed;
  spec.stop = parse_stop(message);
  if (const auto priority = message.find("priority"); priority != message.end() && *priority == "batch")
    spec.priority = Priority::batch;
  take(message, "label", spec.label);
  return spec;
}

}  // namespace photond
