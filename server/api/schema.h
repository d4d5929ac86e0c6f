#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "server/api/json.h"
#include "server/api/problem.h"

namespace photond {

/// The types of JSON values, as bits. Every integer is a number, too.
enum JsonType : unsigned {
  kNull = 1,
  kBoolean = 2,
  kInteger = 4,
  kNumber = 8,
  kString = 16,
  kArray = 32,
  kObject = 64,
  kAnyType = 127
};

/// A JSON Schema (draft 2020-12) in the keywords that openapi.json uses, as plain data. What it points to
/// belongs to the Schemas it comes from.
struct Schema {
  unsigned types = kAnyType;
  std::vector<Json> values;  ///< enum or const; empty: any
  // Of numbers; long double holds every 64-bit integer.
  long double minimum = -std::numeric_limits<long double>::infinity();
  long double maximum = std::numeric_limits<long double>::infinity();
  std::optional<long double> above;  ///< exclusiveMinimum
  // Of strings, in code points.
  std::size_t min_length = 0;
  std::size_t max_length = SIZE_MAX;
  std::optional<std::regex> pattern;  ///< only where max_length is small: std::regex recurses
  bool date_time = false;
  // Of arrays.
  std::size_t min_items = 0;
  std::size_t max_items = SIZE_MAX;
  const Schema* items = nullptr;
  // Of objects.
  std::size_t min_properties = 0;
  std::vector<std::pair<std::string, const Schema*>> properties;
  std::vector<std::string> required;
  bool open = true;                    ///< additionalProperties is not false
  const Schema* additional = nullptr;  ///< of those not in `properties`

  std::vector<const Schema*> one_of;
  const Schema* ref = nullptr;
  std::string description;
  Json missing;  ///< `default`; null where there is none
};

/// The schemas of one document, each read when first asked for.
class Schemas {
 public:
  /// `document` must outlive the object.
  explicit Schemas(const Json& document) : document_(document) {}

  /// The schema at this JSON pointer of the document. Errors: invalid_input (a keyword that is not known, or has a
  /// value it cannot have), not_found, each with the place.
  Result<const Schema*> at(const std::string& pointer);

 private:
  friend class SchemaReader;
  const Json& document_;
  std::deque<Schema> nodes_;
  std::map<std::string, const Schema*> by_pointer_;
};

/// All ways in which `value` breaks `schema`, up to some dozens, with JSON pointers into the value.
std::vector<Violation> check_value(const Schema& schema, const Json& value);

/// Which types of JSON the schema lets through.
unsigned admitted_types(const Schema& schema);

/// What the schema wants, in words: "a whole number from 1 to 16384".
std::string wanted(const Schema& schema);

}  // namespace photond
