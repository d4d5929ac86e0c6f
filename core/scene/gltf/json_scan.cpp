#include "core/scene/gltf/json_scan.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "core/scene/gltf/json_text.h"

namespace photond::gltf {
namespace {

const Schema kAny;

std::string_view kind_name(Schema::Kind kind) {
  switch (kind) {
    case Schema::Kind::boolean:
      return "true or false";
    case Schema::Kind::integer:
      return "an integer";
    case Schema::Kind::number:
      return "a number";
    case Schema::Kind::string:
      return "a string";
    case Schema::Kind::array:
      return "an array";
    case Schema::Kind::object:
      return "an object";
    case Schema::Kind::any:
      break;
  }
  return "a value";
}

std::string text_of(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

/// " from 0 to 1", " at least 0" or " at most 1".
std::string range_words(const Schema& schema) {
  if (!std::isfinite(schema.max)) return " at least " + text_of(schema.min);
  if (!std::isfinite(schema.min)) return " at most " + text_of(schema.max);
  return " from " + text_of(schema.min) + " to " + text_of(schema.max);
}

double parse_double(std::string_view digits) {
  double parsed = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), parsed);
  // from_chars does not tell overflow from underflow; strtod does.
  return status == std::errc() ? parsed : std::strtod(std::string(digits).c_str(), nullptr);
}

/// A recursive descent over the text. Every function returns false once an error is recorded.
class Scanner {
 public:
  Scanner(std::string_view text, const JsonLimits& limits) : text_(text), limits_(limits) {}

  Result<JsonScan> run(const Schema& schema) {
    text_.skip_space();
    if (value(schema)) {
      text_.skip_space();
      if (text_.at_end()) return std::move(scan_);
      fail("unexpected text after the JSON value");
    }
    return *error_;
  }

 private:
  struct Step {
    std::string key;
    std::size_t index = 0;
    bool is_index = false;
  };

  bool fail(std::string message, ErrorCode code = ErrorCode::invalid_input) {
    if (!error_) error_ = Error{code, std::move(message), place()};
    return false;
  }
  bool malformed(std::string_view what) {
    return fail("malformed JSON at byte " + std::to_string(text_.position()) + ": " + std::string(what));
  }

  std::string place() const {
    constexpr std::size_t kMaxSteps = 16;  // nothing of glTF is deeper; what is, is noise
    std::string out;
    for (const Step& step : path_) {
      if (&step == &path_.front() + kMaxSteps) return out + "…";
      if (step.is_index) {
        out.append("[").append(std::to_string(step.index)).append("]");
      } else {
        if (!out.empty()) out += ".";
        out += step.key.substr(0, 80);
      }
    }
    return out;
  }

  bool value(const Schema& schema) {
    if (schema.kind == Schema::Kind::any && ++loose_ > limits_.max_loose_values) {
      return fail("too many values in extras and extensions", ErrorCode::limit_exceeded);
    }
    if (text_.at_end()) return malformed("unexpected end");
    if (text_.peek() == '{' && !count_object()) return false;
    enter(schema.role);
    switch (text_.peek()) {
      case '{':
        return expect(schema, Schema::Kind::object) && nested(schema, &Scanner::object);
      case '[':
        return expect(schema, Schema::Kind::array) && nested(schema, &Scanner::array);
      case '"':
        return expect(schema, Schema::Kind::string) && string(schema);
      case 't':
        return expect(schema, Schema::Kind::boolean) && literal("true");
      case 'f':
        return expect(schema, Schema::Kind::boolean) && literal("false");
      case 'n':
        return (schema.kind == Schema::Kind::any || wrong_kind(schema)) && literal("null");
      default:
        return number(schema);
    }
  }

  bool count_object() {
    return ++objects_ <= limits_.max_objects || fail("too many objects", ErrorCode::limit_exceeded);
  }

  void enter(Role role) {
    if (role == Role::buffer) scan_.buffers.emplace_back();
    if (role == Role::node) ++scan_.nodes;
    if (role == Role::draco) scan_.draco = true;
    if (role == Role::meshopt) scan_.meshopt = true;
    if (role == Role::buffer_fallback) scan_.buffers.back().fallback = text_.peek() == 't';
  }

  bool wrong_kind(const Schema& schema) { return fail("must be " + std::string(kind_name(schema.kind))); }
  bool expect(const Schema& schema, Schema::Kind kind) {
    return schema.kind == Schema::Kind::any || schema.kind == kind || wrong_kind(schema);
  }

  bool nested(const Schema& schema, bool (Scanner::*body)(const Schema&)) {
    if (++depth_ > limits_.max_depth) return fail("nested too deeply", ErrorCode::limit_exceeded);
    text_.take();
    if (!(this->*body)(schema)) return false;
    --depth_;
    return true;
  }

  bool object(const Schema& schema) {
    std::vector<std::string> keys;
    text_.skip_space();
    if (!text_.accept('}')) {
      do {
        if (!member(schema, keys)) return false;
      } while (text_.accept(','));
      if (!text_.accept('}')) return malformed("expected ',' or '}'");
    }
    return check_keys(schema, keys);
  }

  bool member(const Schema& schema, std::vector<std::string>& keys) {
    text_.skip_space();
    if (text_.at_end() || text_.peek() != '"') return malformed("expected a member name");
    std::string key;
    if (auto problem = text_.read_string(&key)) return malformed(*problem);
    text_.skip_space();
    if (!text_.accept(':')) return malformed("expected ':'");
    text_.skip_space();
    keys.push_back(key);
    path_.push_back({.key = std::move(key)});
    if (schema.others && !count_object()) return false;
    if (!value(member_schema(schema, path_.back().key))) return false;
    path_.pop_back();
    text_.skip_space();
    return true;
  }

  static const Schema& member_schema(const Schema& schema, std::string_view key) {
    for (const Field& field : schema.fields) {
      if (field.name == key) return *field.schema;
    }
    return schema.others ? *schema.others : kAny;
  }

  bool check_keys(const Schema& schema, std::vector<std::string>& keys) {
    std::sort(keys.begin(), keys.end());
    auto twice = std::adjacent_find(keys.begin(), keys.end());
    if (twice != keys.end()) return fail("member \"" + twice->substr(0, 80) + "\" appears twice");
    for (const Field& field : schema.fields) {
      if (field.required && !std::binary_search(keys.begin(), keys.end(), field.name)) {
        return fail("member \"" + std::string(field.name) + "\" is missing");
      }
    }
    return true;
  }

  bool array(const Schema& schema) {
    std::size_t count = 0;
    const Schema& items = schema.items ? *schema.items : kAny;
    text_.skip_space();
    if (!text_.accept(']')) {
      do {
        text_.skip_space();
        path_.push_back({.index = count++, .is_index = true});
        if (!value(items)) return false;
        path_.pop_back();
        if (scan_.nodes > limits_.max_nodes) return fail("too many nodes", ErrorCode::limit_exceeded);
        text_.skip_space();
      } while (text_.accept(','));
      if (!text_.accept(']')) return malformed("expected ',' or ']'");
    }
    if (path_.size() == 1) scan_.counts[path_.back().key] = count;
    if (count < schema.min_items) {
      return fail("must have at least " + std::to_string(schema.min_items) + " elements");
    }
    if (count > schema.max_items) {
      return fail("must have at most " + std::to_string(schema.max_items) + " elements");
    }
    return true;
  }

  bool string(const Schema& schema) {
    std::string decoded;
    if (auto problem = text_.read_string(schema.role == Role::none ? nullptr : &decoded)) {
      return malformed(*problem);
    }
    if (schema.role == Role::buffer_uri) scan_.buffers.back().uri = std::move(decoded);
    if (schema.role == Role::extension_required) scan_.extensions_required.push_back(std::move(decoded));
    return true;
  }

  bool literal(std::string_view word) { return text_.accept_word(word) || malformed("unknown word"); }

  bool number(const Schema& schema) {
    bool integral = false;
    const std::string_view digits = text_.read_number(integral);
    if (digits.empty()) return malformed("expected a value");
    if (schema.kind != Schema::Kind::any && schema.kind != Schema::Kind::number &&
        schema.kind != Schema::Kind::integer) {
      return wrong_kind(schema);
    }
    const double parsed = parse_double(digits);
    if (!std::isfinite(parsed)) return fail("is too large a number");
    if (schema.kind == Schema::Kind::integer && !integral) return wrong_kind(schema);
    if (parsed < schema.min || parsed > schema.max) return fail("must be" + range_words(schema));
    if (schema.narrow_integers && integral && std::abs(parsed) > 2147483647.0) {
      return fail("integer is too large; write it with a decimal point");
    }
    if (schema.role == Role::buffer_length) {
      scan_.buffers.back().byte_length = static_cast<std::uint64_t>(parsed);
    }
    return true;
  }

  JsonText text_;
  JsonLimits limits_;
  JsonScan scan_;
  std::vector<Step> path_;
  std::optional<Error> error_;
  std::uint64_t loose_ = 0;
  std::uint64_t objects_ = 0;
  int depth_ = 0;
};

}  // namespace

Result<JsonScan> scan_json(std::string_view text, const Schema& schema, const JsonLimits& limits) {
  return Scanner(text, limits).run(schema);
}

}  // namespace photond::gltf
