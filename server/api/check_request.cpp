#include "server/api/check_request.h"

#include <algorithm>
#include <cctype>
#include <iterator>

#include "server/api/problem.h"
#include "server/api/query.h"

namespace photond {

namespace {

/// The text of a parameter as the JSON value it stands for.
Json typed(const Schema& schema, const std::string& text) {
  const unsigned types = admitted_types(schema);
  if (types & (kInteger | kNumber)) {
    const auto whole = parse_whole(text);
    if (whole) return *whole;
  }
  if ((types & kBoolean) && (text == "true" || text == "false")) return text == "true";
  return text;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool is_utf8(const std::string& text) {
  try {
    (void)Json(text).dump();
    return true;
  } catch (const Json::type_error&) {
    return false;
  }
}

class ParameterCheck {
 public:
  ParameterCheck(const Operation& operation, const Request& request) : operation_(operation), request_(request) {}

  void run() {
    std::size_t placeholder = 0;
    for (const Parameter& parameter : operation_.parameters) {
      switch (parameter.place) {
        case ParameterIn::path:
          take(parameter, "{" + parameter.name + "}", &request_.captures.at(placeholder++));
          break;
        case ParameterIn::query:
          query(parameter);
          break;
        case ParameterIn::header: {
          const auto field = request_.headers.find(lower(parameter.name));
          // Empty text says nothing, unless the contract wants something of it. An empty number is none.
          const bool may_be_empty = admitted_types(*parameter.schema) == kString && parameter.schema->min_length == 0;
          const bool said = field != request_.headers.end() && !(field->second.empty() && may_be_empty);
          take(parameter, parameter.name, said ? &field->second : nullptr);
          break;
        }
      }
      if (parameter.place == ParameterIn::path) wrong_path = wrong_path || !found.empty();
    }
    unknown_query();
  }

  std::vector<Violation> found;
  bool wrong_path = false;
  Json values = Json::object();

 private:
  void take(const Parameter& parameter, const std::string& place, const std::string* text) {
    if (text != nullptr) return accept(parameter, place, typed(*parameter.schema, *text));
    if (parameter.required) found.push_back({place, place + " must be given"});
    if (!parameter.schema->missing.is_null()) values[parameter.name] = parameter.schema->missing;
  }

  void query(const Parameter& parameter) {
    const auto [begin, end] = request_.query.equal_range(parameter.name);
    const std::string place = "?" + parameter.name;
    if (!std::all_of(begin, end, [](const auto& entry) { return is_utf8(entry.second); })) {
      return found.push_back({place, place + " must be UTF-8"});
    }
    if (admitted_types(*parameter.schema) == kArray) {
      Json list = Json::array();
      for (auto entry = begin; entry != end; ++entry) list.push_back(entry->second);
      return accept(parameter, place, std::move(list));
    }
    if (std::distance(begin, end) > 1) return found.push_back({place, place + " must be given once"});
    take(parameter, place, begin == end ? nullptr : &begin->second);
  }

  void unknown_query() {
    for (const auto& [name, value] : request_.query) {
      const bool known = std::any_of(operation_.parameters.begin(), operation_.parameters.end(),
                                     [&name = name](const Parameter& parameter) {
                                       return parameter.place == ParameterIn::query && parameter.name == name;
                                     });
      const std::string place = "?" + name.substr(0, 64);
      if (!known && found.size() < 32) found.push_back({place, place + " is not a known parameter"});
    }
  }

  void accept(const Parameter& parameter, const std::string& place, Json value) {
    for (const Violation& violation : check_value(*parameter.schema, value)) {
      const std::string rule = violation.detail.substr(violation.detail.find(" must"));
      found.push_back({place + violation.where, place + violation.where + rule});
    }
    values[parameter.name] = std::move(value);
  }

  const Operation& operation_;
  const Request& request_;
};

bool is_json(const std::string& type) { return type == "application/json"; }

}  // namespace

std::optional<Response> check_parameters(const Operation& operation, Request& request) {
  ParameterCheck check(operation, request);
  check.run();
  if (check.wrong_path) return problem(404, "not_found", check.found);
  if (!check.found.empty()) return problem(400, "invalid_parameter", check.found);
  request.parameters = std::make_shared<const Json>(std::move(check.values));
  return std::nullopt;
}

std::optional<Response> check_body(const Operation& operation, Request& request) {
  const auto media = operation.body.find(request.content_type);
  if (media == operation.body.end() || !is_json(media->first)) return std::nullopt;
  Result<Json> json = parse_json(request.body);
  if (!json) return problem(400, "invalid_json", json.error().message);
  const std::vector<Violation> found = check_value(*media->second, *json);
  if (!found.empty()) return problem(422, "invalid_body", found);
  request.json = std::make_shared<const Json>(std::move(*json));
  return std::nullopt;
}

}  // namespace photond
