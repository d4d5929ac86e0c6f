// The one file of the store that knows JSON. Jobs have some fifty members in nested structures, most of which no
// query asks for; a table of fifty columns would need a migration for each new one.
#include "server/store/record_text.h"

#include <limits>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>

namespace photond {

namespace {

using Json = nlohmann::ordered_json;

// Each structure lists its members once, for both directions.

template <class Archive>
void members(Archive& a, LookAt& v) {
  a("eye", v.eye), a("target", v.target), a("up", v.up), a("yfov_deg", v.yfov_deg);
}

template <class Archive>
void members(Archive& a, PhotonSettings& v) {
  a("photons_per_pass", v.photons_per_pass), a("seed", v.seed);
}

template <class Archive>
void members(Archive& a, RenderSettings& v) {
  a("method", v.method), a("width", v.width), a("height", v.height), a("seed", v.seed), a("radius", v.radius);
  a("gather_photons", v.gather_photons), a("max_depth", v.max_depth);
}

template <class Archive>
void members(Archive& a, StopRule& v) {
  a("passes", v.passes), a("seconds", v.seconds), a("relative_error", v.relative_error);
}

template <class Archive>
void members(Archive& a, EnvironmentChoice& v) {
  a("id", v.id), a("rotation_deg", v.rotation_deg), a("scale", v.scale);
}

template <class Archive>
void members(Archive& a, JobSpec& v) {
  a("scene", v.scene), a("environment", v.environment), a("camera", v.camera), a("photons", v.photons), a("settings", v.settings);
  a("stop", v.stop), a("priority", v.priority), a("label", v.label);
}

template <class Archive>
void members(Archive& a, PlanItem& v) {
  a("feature", v.feature), a("active", v.active), a("reason", v.reason);
}

template <class Archive>
void members(Archive& a, Plan& v) {
  a("method", v.method), a("biased", v.biased), a("uses_maps", v.uses_maps), a("radius", v.radius);
  a("items", v.items);
}

template <class Archive>
void members(Archive& a, ErrorEstimate& v) {
  a("rmse", v.rmse), a("relative", v.relative), a("noise", v.noise), a("bias", v.bias);
  a("dominated", v.dominated), a("known", v.known);
}

template <class Archive>
void members(Archive& a, Error& v) {
  a("code", v.code), a("message", v.message), a("where", v.where);
}

template <class Archive>
void members(Archive& a, JobNumbers& v) {
  a("state", v.state), a("version", v.version), a("passes", v.passes), a("seconds", v.seconds);
  a("rejected", v.rejected), a("error", v.error), a("eta_seconds", v.eta_seconds), a("map_hits", v.map_hits);
  a("map_disk_hits", v.map_disk_hits), a("map_misses", v.map_misses), a("revision", v.revision);
}

template <class Archive>
void members(Archive& a, JobRecord& v) {
  members(a, static_cast<JobNumbers&>(v));
  a("id", v.id), a("sequence", v.sequence), a("spec", v.spec), a("created", v.created), a("started", v.started);
  a("finished", v.finished), a("plan", v.plan), a("first_frame_seconds", v.first_frame_seconds);
  a("failure", v.failure), a("pause_reason", v.pause_reason), a("crashes", v.crashes), a("owner", v.owner);
  a("least_error", v.least_error);
}

template <class Archive>
void members(Archive& a, Event& v) {
  members(a, static_cast<JobNumbers&>(v));
  a("id", v.id), a("kind", v.kind), a("time", v.time), a("job", v.job);
}

/// Takes members into a JSON object.
class Put {
 public:
  template <class T>
  void operator()(const char* name, T& value) {
    json[name] = of(value);
  }

  template <class T>
  static Json of(T& value) {
    Put put;
    members(put, value);
    return std::move(put.json);
  }
  template <class T>
    requires std::is_arithmetic_v<T>
  static Json of(T& value) {
    return value;  // a number that is not finite becomes null in the text
  }
  template <class T>
    requires std::is_enum_v<T>
  static Json of(T& value) {
    return static_cast<int>(value);
  }
  static Json of(Method& value) { return method_name(value); }
  static Json of(std::string& value) { return value; }
  static Json of(Digest& value) { return to_hex(value); }
  static Json of(Vec3& value) { return Json::array({value.x, value.y, value.z}); }
  static Json of(WallTime& value) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(value.time_since_epoch()).count();
  }
  static Json of(CameraChoice& value) {
    return std::visit([](auto& choice) { return of(choice); }, value);
  }
  template <class T>
  static Json of(std::optional<T>& value) {
    return value ? of(*value) : Json(nullptr);
  }
  template <class T>
  static Json of(std::vector<T>& values) {
    Json list = Json::array();
    for (T& value : values) list.push_back(of(value));
    return list;
  }

  Json json = Json::object();
};

/// Sets members from a JSON object. What is of another type than expected makes `ok` false.
class Take {
 public:
  explicit Take(const Json& object) : json_(object), ok(object.is_object()) {}

  template <class T>
  void operator()(const char* name, T& value) {
    if (!ok) return;
    const auto found = json_.find(name);
    if (found != json_.end()) ok = set(*found, value);
  }

  template <class T>
  static bool set(const Json& json, T& value) {
    Take take(json);
    members(take, value);
    return take.ok;
  }
  template <class T>
    requires std::is_arithmetic_v<T>
  static bool set(const Json& json, T& value) {
    if (std::is_floating_point_v<T> && json.is_null()) {
      value = std::numeric_limits<T>::quiet_NaN();
      return true;
    }
    if (std::is_same_v<T, bool> ? !json.is_boolean() : !json.is_number()) return false;
    value = json.get<T>();
    return true;
  }
  template <class T>
    requires std::is_enum_v<T>
  static bool set(const Json& json, T& value) {
    if (!json.is_number_integer() || json < 0 || json > 255) return false;
    value = static_cast<T>(json.get<int>());
    return true;
  }
  static bool set(const Json& json, Method& value) {
    const auto method = json.is_string() ? method_from_name(json.get_ref<const std::string&>().c_str())
                                         : std::optional<Method>();
    if (method) value = *method;
    return method.has_value();
  }
  static bool set(const Json& json, std::string& value) {
    if (!json.is_string()) return false;
    value = json.get<std::string>();
    return true;
  }
  static bool set(const Json& json, Digest& value) {
    const auto digest = json.is_string() ? digest_from_hex(json.get_ref<const std::string&>()) : std::nullopt;
    if (digest) value = *digest;
    return digest.has_value();
  }
  static bool set(const Json& json, Vec3& value) {
    if (!json.is_array() || json.size() != 3) return false;
    return set(json[0], value.x) && set(json[1], value.y) && set(json[2], value.z);
  }
  static bool set(const Json& json, WallTime& value) {
    if (!json.is_number_integer()) return false;
    value = WallTime(std::chrono::milliseconds(json.get<std::int64_t>()));
    return true;
  }
  static bool set(const Json& json, CameraChoice& value) {
    if (json.is_number_unsigned()) return set(json, value.emplace<std::uint32_t>());
    if (json.is_string()) return set(json, value.emplace<std::string>());
    return set(json, value.emplace<LookAt>());
  }
  template <class T>
  static bool set(const Json& json, std::optional<T>& value) {
    value.reset();
    return json.is_null() || set(json, value.emplace());
  }
  template <class T>
  static bool set(const Json& json, std::vector<T>& values) {
    if (!json.is_array()) return false;
    values.assign(json.size(), T{});
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!set(json[i], values[i])) return false;
    }
    return true;
  }

 private:
  const Json& json_;

 public:
  bool ok;
};

template <class T>
std::string text_of(T value) {
  // Names in a scene file need not be UTF-8.
  return Put::of(value).dump(-1, ' ', false, Json::error_handler_t::replace);
}

template <class T>
Result<T> value_of(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  T value{};
  if (!json.is_discarded() && Take::set(json, value)) return value;
  return Error{ErrorCode::io, "the database holds a record that cannot be read", ""};
}

}  // namespace

std::string record_text(const JobRecord& job) { return text_of(job); }
Result<JobRecord> read_record(std::string_view text) { return value_of<JobRecord>(text); }
std::string event_text(const Event& event) { return text_of(event); }
Result<Event> read_event(std::string_view text) { return value_of<Event>(text); }

std::optional<std::string> error_text(const std::optional<ErrorEstimate>& error) {
  return error ? std::optional(text_of(*error)) : std::nullopt;
}

Result<std::optional<ErrorEstimate>> read_error(std::string_view text) {
  if (text.empty()) return std::optional<ErrorEstimate>();
  const Result<ErrorEstimate> error = value_of<ErrorEstimate>(text);
  if (!error) return error.error();
  return std::optional(*error);
}

}  // namespace photond
