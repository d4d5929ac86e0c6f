#include "server/api/schema.h"

#include <cmath>

namespace photond {

namespace {

constexpr std::size_t kLongestPatternText = 256;  // std::regex recurses for every character

std::optional<unsigned> type_bits(const Json& name) {
  static const std::map<std::string, unsigned> kTypes{
      {"null", kNull},     {"boolean", kBoolean}, {"integer", kInteger}, {"number", kNumber | kInteger},
      {"string", kString}, {"array", kArray},     {"object", kObject}};
  const auto found = name.is_string() ? kTypes.find(name.get_ref<const std::string&>()) : kTypes.end();
  return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

/// Reads one schema object, keyword by keyword; the first mistake stays.
class SchemaReader {
 public:
  SchemaReader(Schemas& schemas, Schema& schema, std::string pointer)
      : schemas_(schemas), schema_(schema), pointer_(std::move(pointer)) {}

  Status read(const Json& source) {
    if (!source.is_object()) return invalid_input("a schema must be an object", pointer_);
    for (const auto& [keyword, value] : source.items()) {
      const auto known = keywords().find(keyword);
      if (known == keywords().end()) return invalid_input("the keyword " + keyword + " is not known", pointer_);
      if (!(this->*known->second)(value)) return invalid_input("bad value of " + keyword + reason_, pointer_);
    }
    if (schema_.pattern && schema_.max_length > kLongestPatternText)
      return invalid_input("a pattern needs a maxLength of at most " + std::to_string(kLongestPatternText), pointer_);
    return Done{};
  }

 private:
  using Keyword = bool (SchemaReader::*)(const Json&);
  static const std::map<std::string, Keyword>& keywords() {
    static const std::map<std::string, Keyword> kKeywords{
        {"type", &SchemaReader::type},
        {"enum", &SchemaReader::values},
        {"const", &SchemaReader::constant},
        {"minimum", &SchemaReader::minimum},
        {"maximum", &SchemaReader::maximum},
        {"exclusiveMinimum", &SchemaReader::above},
        {"minLength", &SchemaReader::min_length},
        {"maxLength", &SchemaReader::max_length},
        {"pattern", &SchemaReader::pattern},
        {"format", &SchemaReader::format},
        {"minItems", &SchemaReader::min_items},
        {"maxItems", &SchemaReader::max_items},
        {"items", &SchemaReader::items},
        {"minProperties", &SchemaReader::min_properties},
        {"properties", &SchemaReader::properties},
        {"required", &SchemaReader::required},
        {"additionalProperties", &SchemaReader::additional},
        {"oneOf", &SchemaReader::one_of},
        {"$ref", &SchemaReader::ref},
        {"description", &SchemaReader::description},
        {"default", &SchemaReader::missing},
        {"examples", &SchemaReader::examples}};
    return kKeywords;
  }

  bool type(const Json& value) {
    unsigned bits = 0;
    for (const Json& name : value.is_array() ? value : Json::array({value})) {
      const auto bit = type_bits(name);
      if (!bit) return false;
      bits |= *bit;
    }
    schema_.types = bits;
    return true;
  }
  bool values(const Json& value) {
    schema_.values.assign(value.begin(), value.end());
    return value.is_array() && !value.empty();
  }
  bool constant(const Json& value) {
    schema_.values = {value};
    return true;
  }

  static bool bound(const Json& value, long double& to) {
    if (!value.is_number()) return false;
    to = value.is_number_unsigned() ? static_cast<long double>(value.get<std::uint64_t>()) : value.get<double>();
    return true;
  }
  bool minimum(const Json& value) { return bound(value, schema_.minimum); }
  bool maximum(const Json& value) { return bound(value, schema_.maximum); }
  bool above(const Json& value) { return bound(value, schema_.above.emplace()); }

  static bool count(const Json& value, std::size_t& to) {
    if (!value.is_number_unsigned()) return false;
    to = value.get<std::size_t>();
    return true;
  }
  bool min_length(const Json& value) { return count(value, schema_.min_length); }
  bool max_length(const Json& value) { return count(value, schema_.max_length); }
  bool min_items(const Json& value) { return count(value, schema_.min_items); }
  bool max_items(const Json& value) { return count(value, schema_.max_items); }
  bool min_properties(const Json& value) { return count(value, schema_.min_properties); }

  bool pattern(const Json& value) {
    if (!value.is_string()) return false;
    try {
      schema_.pattern.emplace(value.get<std::string>(), std::regex::ECMAScript);
    } catch (const std::regex_error&) {
      return false;
    }
    return true;
  }
  bool format(const Json& value) { return schema_.date_time = value == "date-time"; }
  bool description(const Json& value) {
    if (value.is_string()) schema_.description = value.get<std::string>();
    return value.is_string();
  }
  bool missing(const Json& value) {
    schema_.missing = value;
    return true;
  }
  bool examples(const Json& value) { return value.is_array(); }  // tested by the tests

  /// The schema at `place` below this one.
  const Schema* part(const std::string& place) { return at(pointer_ + place); }
  const Schema* at(const std::string& pointer) {
    const Result<const Schema*> schema = schemas_.at(pointer);
    if (!schema) reason_ = ": " + schema.error().message + " at " + schema.error().where;
    return schema ? *schema : nullptr;
  }

  bool items(const Json&) { return (schema_.items = part("/items")) != nullptr; }
  bool properties(const Json& value) {
    if (!value.is_object()) return false;
    for (const auto& [name, ignored] : value.items()) {
      const Schema* property = part("/properties/" + pointer_token(name));
      if (property == nullptr) return false;
      schema_.properties.emplace_back(name, property);
    }
    return true;
  }
  bool required(const Json& value) {
    if (!value.is_array()) return false;
    for (const Json& name : value) {
      if (!name.is_string()) return false;
      schema_.required.push_back(name.get<std::string>());
    }
    return true;
  }
  bool additional(const Json& value) {
    if (value.is_boolean()) {
      schema_.open = value.get<bool>();
      return true;
    }
    return (schema_.additional = part("/additionalProperties")) != nullptr;
  }
  bool one_of(const Json& value) {
    if (!value.is_array() || value.empty()) return false;
    for (std::size_t i = 0; i < value.size(); ++i) {
      const Schema* branch = part("/oneOf/" + std::to_string(i));
      if (branch == nullptr) return false;
      schema_.one_of.push_back(branch);
    }
    return true;
  }
  bool ref(const Json& value) {
    if (!value.is_string() || !value.get_ref<const std::string&>().starts_with("#/")) return false;
    return (schema_.ref = at(value.get<std::string>().substr(1))) != nullptr;
  }

  Schemas& schemas_;
  Schema& schema_;
  const std::string pointer_;
  std::string reason_;
};

Result<const Schema*> Schemas::at(const std::string& pointer) {
  if (const auto known = by_pointer_.find(pointer); known != by_pointer_.end()) return known->second;
  const Json* source = find_pointer(document_, pointer);
  if (source == nullptr) return Error{ErrorCode::not_found, "there is no schema", pointer};
  Schema& schema = nodes_.emplace_back();
  by_pointer_.emplace(pointer, &schema);  // before its parts are read: they may refer to it
  if (const Status read = SchemaReader(*this, schema, pointer).read(*source); !read) {
    by_pointer_.erase(pointer);
    return read.error();
  }
  return &schema;
}

}  // namespace photond
