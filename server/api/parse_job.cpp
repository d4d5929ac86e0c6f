#include <cmath>
#include <initializer_list>
#include <optional>

#include "server/api/job_message.h"

namespace photond {

namespace {

/// Reads the fields of one JSON object; the first mistake stays, later calls do nothing.
class FieldReader {
 public:
  FieldReader(const Json& object, std::string pointer, std::optional<Error>& error)
      : object_(object), pointer_(std::move(pointer)), error_(error) {
    if (!object_.is_object()) fail("", "must be an object");
  }

  /// Call once with all known names.
  void only(std::initializer_list<const char*> names) {
    if (!object_.is_object()) return;
    for (const auto& [key, value] : object_.items()) {
      bool known = false;
      for (const char* name : names) known = known || key == name;
      if (!known) fail(escaped(key), "is not a known field");
    }
  }

  /// Null where absent or JSON null (both mean the default).
  const Json* find(const char* name) const {
    if (error_ || !object_.is_object()) return nullptr;
    const auto found = object_.find(name);
    return found == object_.end() || found->is_null() ? nullptr : &*found;
  }

  std::optional<std::string> text(const char* name, std::size_t max_bytes) {
    const Json* value = find(name);
    if (value == nullptr) return std::nullopt;
    if (!value->is_string()) return fail(name, "must be a string"), std::nullopt;
    if (value->get_ref<const std::string&>().size() > max_bytes) {
      return fail(name, "must not be longer than " + std::to_string(max_bytes) + " bytes"), std::nullopt;
    }
    return value->get<std::string>();
  }

  std::optional<std::uint64_t> whole(const char* name, std::uint64_t min, std::uint64_t max) {
    const Json* value = find(name);
    if (value == nullptr) return std::nullopt;
    const bool unsigned_value = value->is_number_unsigned();
    if (!unsigned_value || value->get<std::uint64_t>() < min || value->get<std::uint64_t>() > max) {
      return fail(name, "must be a whole number from " + std::to_string(min) + " to " + std::to_string(max)),
             std::nullopt;
    }
    return value->get<std::uint64_t>();
  }

  std::optional<double> number(const char* name) {
    const Json* value = find(name);
    if (value == nullptr) return std::nullopt;
    if (!value->is_number() || !std::isfinite(value->get<double>())) {
      return fail(name, "must be a number"), std::nullopt;
    }
    return value->get<double>();
  }

  std::optional<Vec3> vector(const char* name) {
    const Json* value = find(name);
    if (value == nullptr) return std::nullopt;
    bool fine = value->is_array() && value->size() == 3;
    for (std::size_t i = 0; fine && i < 3; ++i) fine = (*value)[i].is_number();
    if (!fine) return fail(name, "must be an array of three numbers"), std::nullopt;
    const Vec3 v{(*value)[0].get<float>(), (*value)[1].get<float>(), (*value)[2].get<float>()};
    if (!is_finite(v)) return fail(name, "is out of range"), std::nullopt;
    return v;
  }

  void fail(const std::string& name, const std::string& rule) {
    if (error_) return;
    const std::string where = name.empty() ? pointer_ : pointer_ + "/" + name;
    error_ = invalid_input((where.empty() ? "the message" : where) + " " + rule, where);
  }

 private:
  static std::string escaped(const std::string& key) {
    std::string text;
    for (const char c : key.substr(0, 64)) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
    return text;
  }

  const Json& object_;
  const std::string pointer_;
  std::optional<Error>& error_;
};

void read_scene(FieldReader& fields, JobSpec& spec) {
  const auto text = fields.text("scene", 64);
  const auto id = text ? digest_from_hex(*text) : std::nullopt;
  if (id)
    spec.scene = *id;
  else
    fields.fail("scene", "must be given, as the 64 hexadecimal digits of a scene's id");
}

void read_placement(const Json& object, JobSpec& spec, std::optional<Error>& error) {
  FieldReader fields(object, "/camera", error);
  fields.only({"eye", "target", "up", "yfov_deg"});
  LookAt placed;
  const auto eye = fields.vector("eye");
  const auto target = fields.vector("target");
  if (!eye) fields.fail("eye", "must be given");
  if (!target) fields.fail("target", "must be given");
  if (error) return;
  placed.eye = *eye;
  placed.target = *target;
  placed.up = fields.vector("up").value_or(placed.up);
  placed.yfov_deg = static_cast<float>(fields.number("yfov_deg").value_or(placed.yfov_deg));
  if (!(placed.yfov_deg >= 0.1f && placed.yfov_deg <= 175)) fields.fail("yfov_deg", "must be from 0.1 to 175");
  const Vec3 view = placed.target - placed.eye;
  if (!(glm::length(view) > 0) || !std::isfinite(glm::length(view)))
    fields.fail("target", "must not be the eye");
  if (!(glm::length(placed.up) > 0) || !std::isfinite(glm::length(placed.up)))
    fields.fail("up", "must not be zero");
  if (error) return;
  const float sine = glm::length(glm::cross(glm::normalize(view), glm::normalize(placed.up)));
  if (!(sine > 1e-4f)) fields.fail("up", "must not be parallel to the view");
  spec.camera = placed;
}

void read_camera(FieldReader& fields, JobSpec& spec, std::optional<Error>& error) {
  const Json* camera = fields.find("camera");
  if (camera == nullptr) return;
  if (camera->is_string()) {
    spec.camera = fields.text("camera", 1024).value_or("");
  } else if (camera->is_number_unsigned()) {
    spec.camera = static_cast<std::uint32_t>(fields.whole("camera", 0, 1'000'000).value_or(0));
  } else if (camera->is_object()) {
    read_placement(*camera, spec, error);
  } else {
    fields.fail("camera", "must be a name, an index or a placement {eye, target, up, yfov_deg}");
  }
}

void read_film(FieldReader& job, JobSpec& spec, std::optional<Error>& error) {
  const Json* film = job.find("film");
  if (film == nullptr) return;
  FieldReader fields(*film, "/film", error);
  fields.only({"width", "height"});
  spec.settings.width = static_cast<int>(fields.whole("width", 1, 16'384).value_or(spec.settings.width));
  spec.settings.height = static_cast<int>(fields.whole("height", 1, 16'384).value_or(spec.settings.height));
}

void read_method(FieldReader& fields, JobSpec& spec) {
  const auto name = fields.text("method", 64);
  if (!name) return;
  const auto method = method_from_name(name->c_str());
  if (method)
    spec.settings.method = *method;
  else
    fields.fail("method", "must be auto, path, photon_map or progressive");
}

void read_settings(FieldReader& fields, JobSpec& spec) {
  PhotonSettings& photons = spec.photons;
  RenderSettings& settings = spec.settings;
  photons.photons_per_pass = static_cast<std::uint32_t>(
      fields.whole("photons_per_pass", 1, 100'000'000).value_or(photons.photons_per_pass));
  settings.gather_photons =
      static_cast<std::uint32_t>(fields.whole("gather_photons", 1, 4096).value_or(settings.gather_photons));
  settings.seed = fields.whole("seed", 0, UINT64_MAX).value_or(settings.seed);
  photons.seed = settings.seed;
  const double radius = fields.number("radius").value_or(settings.radius);
  settings.radius = static_cast<float>(radius);
  if (!(radius >= 0) || !std::isfinite(settings.radius))
    fields.fail("radius", "must be 0 (automatic) or positive");
}

void read_stop(FieldReader& job, JobSpec& spec, std::optional<Error>& error) {
  const Json* stop = job.find("stop");
  if (stop == nullptr) {
    // An unattended job must end: a minute suffices for a first look, 256 passes for a good picture.
    spec.stop.passes = 256;
    spec.stop.seconds = 60;
    return;
  }
  FieldReader fields(*stop, "/stop", error);
  fields.only({"passes", "seconds", "relative_error"});
  if (const auto passes = fields.whole("passes", 1, 1'000'000))
    spec.stop.passes = static_cast<std::uint32_t>(*passes);
  spec.stop.seconds = fields.number("seconds");
  spec.stop.relative_error = fields.number("relative_error");
  if (spec.stop.seconds && !(*spec.stop.seconds > 0 && *spec.stop.seconds <= 1e6)) {
    fields.fail("seconds", "must be positive and at most 1000000");
  }
  if (spec.stop.relative_error && !(*spec.stop.relative_error > 0))
    fields.fail("relative_error", "must be positive");
  const bool any = spec.stop.passes || spec.stop.seconds || spec.stop.relative_error;
  if (!any) fields.fail("", "must name passes, seconds or relative_error");
}

void read_priority(FieldReader& fields, JobSpec& spec) {
  const auto name = fields.text("priority", 64);
  if (!name || *name == "interactive") return;
  if (*name == "batch")
    spec.priority = Priority::batch;
  else
    fields.fail("priority", "must be interactive or batch");
}

}  // namespace

Result<JobSpec> parse_job(std::span<const std::byte> text) {
  const Result<Json> json = parse_json(text);
  if (!json) return json.error();
  std::optional<Error> error;
  JobSpec spec;
  FieldReader fields(*json, "", error);
  fields.only({"scene", "camera", "film", "method", "photons_per_pass", "radius", "gather_photons", "seed",
               "stop", "priority", "label"});
  read_scene(fields, spec);
  read_camera(fields, spec, error);
  read_film(fields, spec, error);
  read_method(fields, spec);
  read_settings(fields, spec);
  read_stop(fields, spec, error);
  read_priority(fields, spec);
  spec.label = fields.text("label", 200).value_or("");
  if (error) return *error;
  return spec;
}

}  // namespace photond
