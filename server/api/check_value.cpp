#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "server/api/schema.h"

namespace photond {

namespace {

constexpr std::size_t kMostViolations = 32;

unsigned type_of(const Json& value) {
  switch (value.type()) {
    case Json::value_t::null:
      return kNull;
    case Json::value_t::boolean:
      return kBoolean;
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
      return kInteger;
    case Json::value_t::number_float: {
      const double number = value.get<double>();
      return std::trunc(number) == number ? kInteger : kNumber;  // 2.0 is an integer, says JSON Schema
    }
    case Json::value_t::string:
      return kString;
    case Json::value_t::array:
      return kArray;
    default:
      return kObject;
  }
}

std::size_t code_points(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

/// `2026-01-31T12:00:00.123Z`, with any number of decimals, or an offset for the Z.
bool is_date_time(const std::string& text) {
  static const std::regex kForm(
      R"(\d{4}-(0[1-9]|1[0-2])-(0[1-9]|[12]\d|3[01])T([01]\d|2[0-3]):[0-5]\d:([0-5]\d|60)(\.\d{1,9})?(Z|[+-]\d\d:\d\d))");
  return text.size() <= 40 && std::regex_match(text, kForm);
}

bool fits_number(const Schema& schema, const Json& value) {
  const long double number = value.is_number_unsigned()  ? static_cast<long double>(value.get<std::uint64_t>())
                             : value.is_number_integer() ? static_cast<long double>(value.get<std::int64_t>())
                                                         : static_cast<long double>(value.get<double>());
  return number >= schema.minimum && number <= schema.maximum && (!schema.above || number > *schema.above);
}

bool fits_string(const Schema& schema, const std::string& text) {
  const std::size_t length = code_points(text);
  if (length < schema.min_length || length > schema.max_length) return false;
  if (schema.date_time && !is_date_time(text)) return false;
  return !schema.pattern || std::regex_search(text, *schema.pattern);
}

/// Everything that the value alone decides, without its parts.
bool fits(const Schema& schema, const Json& value) {
  if ((schema.types & type_of(value)) == 0) return false;
  if (!schema.values.empty() && std::find(schema.values.begin(), schema.values.end(), value) == schema.values.end())
    return false;
  if (value.is_number()) return fits_number(schema, value);
  if (value.is_string()) return fits_string(schema, value.get_ref<const std::string&>());
  if (value.is_array()) return value.size() >= schema.min_items && value.size() <= schema.max_items;
  return !value.is_object() || value.size() >= schema.min_properties;
}

class Check {
 public:
  void value(const Schema& schema, const Json& value, const std::string& where) {
    if (found.size() >= kMostViolations) return;
    if (schema.ref != nullptr) this->value(*schema.ref, value, where);
    if (!fits(schema, value)) return fail(where, "must be " + wanted(schema));
    if (value.is_object()) members(schema, value, where);
    if (value.is_array() && schema.items != nullptr) {
      for (std::size_t i = 0; i < value.size(); ++i) this->value(*schema.items, value[i], where + "/" + std::to_string(i));
    }
    if (!schema.one_of.empty()) alternatives(schema, value, where);
  }

  std::vector<Violation> found;

 private:
  void fail(const std::string& where, const std::string& rule) {
    if (found.size() < kMostViolations) found.push_back({where, (where.empty() ? "the message" : where) + " " + rule});
  }

  void members(const Schema& schema, const Json& object, const std::string& where) {
    for (const std::string& name : schema.required) {
      if (!object.contains(name)) fail(where + "/" + pointer_token(name), "must be given");
    }
    for (const auto& [name, member] : object.items()) {
      const std::string place = where + "/" + pointer_token(name.substr(0, 64));
      const auto known = std::find_if(schema.properties.begin(), schema.properties.end(),
                                      [&name = name](const auto& property) { return property.first == name; });
      if (known != schema.properties.end()) {
        value(*known->second, member, place);
      } else if (!schema.open) {
        fail(place, "is not a known field");
      } else if (schema.additional != nullptr) {
        value(*schema.additional, member, place);
      }
    }
  }

  /// Exactly one branch must hold. Where none does and only one has the value's type, its complaints are the useful
  /// ones.
  void alternatives(const Schema& schema, const Json& value, const std::string& where) {
    std::size_t holds = 0;
    std::vector<std::vector<Violation>> near;
    for (const Schema* branch : schema.one_of) {
      Check check;
      check.value(*branch, value, where);
      holds += check.found.empty();
      if ((admitted_types(*branch) & type_of(value)) != 0) near.push_back(std::move(check.found));
    }
    if (holds == 1) return;
    if (holds == 0 && near.size() == 1) {
      for (Violation& violation : near.front()) found.push_back(std::move(violation));
    } else {
      fail(where, "must be " + std::string(holds > 1 ? "only one of: " : "") + wanted(schema));
    }
  }
};

std::string number_text(long double number) {
  char text[64];
  if (number == std::trunc(number)) {
    std::snprintf(text, sizeof text, "%.20Lg", number);
    return text;
  }
  // 0.1, not 0.10000000000000000555: the contract's numbers are doubles.
  return {text, std::to_chars(text, text + sizeof text, static_cast<double>(number)).ptr};
}

std::string range_words(const Schema& schema) {
  const bool low = std::isfinite(schema.minimum);
  const bool high = std::isfinite(schema.maximum);
  std::string words;
  if (schema.above) words += " above " + number_text(*schema.above) + (high ? " and" : "");
  if (low) words += " from " + number_text(schema.minimum) + (high ? "" : " on");
  if (high) words += (low ? " to " : " up to ") + number_text(schema.maximum);
  return words;
}

std::string string_words(const Schema& schema) {
  if (schema.date_time) return "a date and time";
  if (schema.pattern) return schema.description.empty() ? "a string of the right form" : "a " + schema.description;
  if (schema.max_length != SIZE_MAX) return "a string of at most " + std::to_string(schema.max_length) + " characters";
  return "a string";
}

std::string array_words(const Schema& schema) {
  if (schema.min_items == schema.max_items) return "an array of " + std::to_string(schema.min_items) + " items";
  if (schema.max_items != SIZE_MAX) return "an array of at most " + std::to_string(schema.max_items) + " items";
  return "an array";
}

std::string join(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 == parts.size() ? " or " : ", ") + parts[i];
  return text;
}

}  // namespace

unsigned admitted_types(const Schema& schema) {
  unsigned types = schema.types;
  if (!schema.values.empty()) {
    unsigned of_values = 0;
    for (const Json& value : schema.values) of_values |= type_of(value);
    types &= of_values;
  }
  if (!schema.one_of.empty()) {
    unsigned of_branches = 0;
    for (const Schema* branch : schema.one_of) of_branches |= admitted_types(*branch);
    types &= of_branches;
  }
  return schema.ref != nullptr ? types & admitted_types(*schema.ref) : types;
}

std::string wanted(const Schema& schema) {
  std::vector<std::string> parts;
  if (!schema.values.empty()) {
    for (const Json& value : schema.values) parts.push_back(value.is_string() ? value.get<std::string>() : to_text(value));
    return join(parts);
  }
  if (!schema.one_of.empty()) {
    for (const Schema* branch : schema.one_of) parts.push_back(wanted(*branch));
    return join(parts);
  }
  if (schema.ref != nullptr) return wanted(*schema.ref);
  if (schema.types & kNumber)
    parts.push_back("a number" + range_words(schema));
  else if (schema.types & kInteger)
    parts.push_back("a whole number" + range_words(schema));
  if (schema.types & kString) parts.push_back(string_words(schema));
  if (schema.types & kArray) parts.push_back(array_words(schema));
  if (schema.types & kObject) parts.push_back(schema.min_properties > 0 ? "an object that is not empty" : "an object");
  if (schema.types & kBoolean) parts.push_back("true or false");
  if (schema.types & kNull) parts.push_back("null");
  return join(parts);
}

std::vector<Violation> check_value(const Schema& schema, const Json& value) {
  Check check;
  check.value(schema, value, "");
  return std::move(check.found);
}

}  // namespace photond
