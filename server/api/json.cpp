#include "server/api/json.h"

#include <ctime>
#include <set>
#include <vector>

#include "server/api/query.h"

namespace photond {

namespace {

/// Builds the value by the library's own DOM builder, after this object has looked at the structure: the
/// library recurses without limit when it destroys or prints, and lets the last of equal keys win.
class StructureCheck : public nlohmann::json_sax<Json> {
 public:
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_object(std::size_t) override { return enter(); }
  bool end_object() override { return leave(); }
  bool start_array(std::size_t) override { return enter(); }
  bool end_array() override { return leave(); }
  bool key(string_t& name) override {
    if (keys_.back().insert(name).second) return true;
    return fail("the key \"" + name.substr(0, 64) + "\" appears twice in one object");
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception&) override {
    return fail("not valid JSON at byte " + std::to_string(position));
  }
  const std::string& reason() const { return reason_; }

 private:
  bool enter() {
    keys_.emplace_back();
    if (keys_.size() <= static_cast<std::size_t>(kMaxJsonDepth)) return true;
    return fail("more than " + std::to_string(kMaxJsonDepth) + " levels of nesting");
  }
  bool leave() {
    keys_.pop_back();
    return true;
  }
  bool fail(std::string reason) {
    reason_ = std::move(reason);
    return false;
  }

  std::vector<std::set<std::string>> keys_;
  std::string reason_;
};

}  // namespace

Result<Json> parse_json(std::span<const std::byte> text) {
  const char* begin = reinterpret_cast<const char*>(text.data());
  const char* end = begin + text.size();
  StructureCheck check;
  if (!Json::sax_parse(begin, end, &check)) return invalid_input(check.reason());
  return Json::parse(begin, end, nullptr, false);
}

std::string pointer_token(const std::string& name) {
  std::string text;
  for (const char c : name) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return text;
}

const Json* find_pointer(const Json& document, std::string_view pointer) {
  const Json* at = &document;
  while (!pointer.empty()) {
    if (pointer.front() != '/') return nullptr;
    const std::string_view token = pointer.substr(1, pointer.find('/', 1) - 1);
    pointer.remove_prefix(1 + token.size());
    const Json* next = nullptr;
    if (at->is_object()) {
      for (const auto& [name, member] : at->items()) {
        if (pointer_token(name) == token) next = &member;
      }
    } else if (at->is_array()) {
      const auto index = parse_whole(token);
      if (index && *index < at->size()) next = &(*at)[*index];
    }
    if (next == nullptr) return nullptr;
    at = next;
  }
  return at;
}

std::string to_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Response json_response(const Json& body, int status) {
  Response response;
  response.status = status;
  response.content_type = "application/json";
  response.headers.emplace_back("Cache-Control", "no-store");
  response.body = to_text(body);
  return response;
}

std::string time_text(std::chrono::system_clock::time_point time) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
  const std::time_t seconds = static_cast<std::time_t>(ms / 1000);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char text[64];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
  char fraction[8];
  std::snprintf(fraction, sizeof fraction, ".%03dZ", static_cast<int>(ms % 1000));
  return std::string(text) + fraction;
}

}  // namespace photond
