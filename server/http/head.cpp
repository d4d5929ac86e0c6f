#include "server/http/head.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace photond {

namespace {

constexpr std::size_t kMaxTarget = 4096;
constexpr std::size_t kMaxPath = 512;
constexpr std::size_t kMaxFields = 100;

/// Fields that decide what a request is or who sends it: with two of them no order of precedence is safe.
constexpr std::array<std::string_view, 10> kOnlyOnce{
    "host",   "content-length", "transfer-encoding", "content-type",    "content-encoding",
    "range",  "authorization",  "origin",            "idempotency-key", "x-request-id"};

BadHead malformed(std::string detail) { return {400, std::move(detail)}; }

bool is_token_char(unsigned char c) {
  return std::isalnum(c) != 0 || std::string_view("!#$%&'*+-.^_`|~").find(static_cast<char>(c)) != std::string_view::npos;
}

bool is_token(std::string_view text) { return !text.empty() && std::all_of(text.begin(), text.end(), is_token_char); }

/// The next line without its end, taken off `rest`; none where the line does not end by CRLF.
std::optional<std::string_view> take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  if (end == std::string_view::npos || end == 0 || rest[end - 1] != '\r') return std::nullopt;
  const std::string_view line = rest.substr(0, end - 1);
  rest.remove_prefix(end + 1);
  return line;
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

std::string_view trimmed(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const int letter = std::tolower(static_cast<unsigned char>(c));
  return letter >= 'a' && letter <= 'f' ? letter - 'a' + 10 : -1;
}

/// Whether every % is followed by two hexadecimal digits that stand for no control character.
bool decodes_cleanly(std::string_view text) {
  for (std::size_t at = text.find('%'); at != std::string_view::npos; at = text.find('%', at + 1)) {
    if (at + 2 >= text.size()) return false;
    const int high = hex_value(text[at + 1]);
    const int low = hex_value(text[at + 2]);
    if (high < 0 || low < 0 || high * 16 + low < 0x20 || high * 16 + low == 0x7f) return false;
  }
  return true;
}

std::optional<BadHead> read_target(std::string_view target, Head& head) {
  if (target.size() > kMaxTarget || target.substr(0, target.find('?')).size() > kMaxPath) {
    return BadHead{414, "the path or the query is too long"};
  }
  const bool printable = std::all_of(target.begin(), target.end(), [](char c) { return c > 0x20 && c < 0x7f && c != '#'; });
  if (!target.starts_with('/') || !printable) return malformed("the target must be a path that begins with /");
  if (!decodes_cleanly(target)) return malformed("the target is not properly percent-encoded");
  head.target = target;
  return std::nullopt;
}

std::optional<BadHead> read_request_line(std::string_view line, Head& head) {
  const std::size_t first = line.find(' ');
  const std::size_t last = line.rfind(' ');
  if (first == std::string_view::npos || first == last) return malformed("the first line is no request");
  const std::string_view version = line.substr(last + 1);
  if (version != "HTTP/1.1" && version != "HTTP/1.0") {
    return version.starts_with("HTTP/") ? BadHead{505, "only HTTP/1.1 and HTTP/1.0 are served"}
                                        : malformed("the first line is no request");
  }
  head.http10 = version == "HTTP/1.0";
  head.method = line.substr(0, first);
  if (!is_token(head.method)) return malformed("the method is malformed");
  constexpr std::array<std::string_view, 7> kMethods{"GET", "HEAD", "POST", "PUT", "DELETE", "PATCH", "OPTIONS"};
  if (std::find(kMethods.begin(), kMethods.end(), head.method) == kMethods.end()) {
    return BadHead{501, "this method is not known"};
  }
  return read_target(line.substr(first + 1, last - first - 1), head);
}

std::optional<BadHead> read_field(std::string_view line, Head& head) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) return malformed("a header line is malformed");
  const std::string_view value = trimmed(line.substr(colon + 1));
  const bool clean = std::none_of(value.begin(), value.end(), [](unsigned char c) { return (c < 0x20 && c != '\t') || c == 0x7f; });
  if (!clean) return malformed("a header value has control characters");
  const std::string name = lower(line.substr(0, colon));
  const auto [place, fresh] = head.fields.emplace(name, value);
  if (fresh) return std::nullopt;
  if (std::find(kOnlyOnce.begin(), kOnlyOnce.end(), name) != kOnlyOnce.end()) {
    return malformed("the header " + name + " is stated twice");
  }
  place->second += ", ";
  place->second += value;
  return std::nullopt;
}

std::optional<BadHead> read_length(Head& head) {
  const auto coding = head.fields.find("transfer-encoding");
  const auto length = head.fields.find("content-length");
  if (coding != head.fields.end()) {
    if (length != head.fields.end()) return malformed("the length of the body is stated twice");
    if (head.http10) return malformed("HTTP/1.0 knows no Transfer-Encoding");
    if (lower(coding->second) != "chunked") return BadHead{501, "only the transfer encoding chunked is supported"};
    head.chunked = true;
    return std::nullopt;
  }
  if (length == head.fields.end()) return std::nullopt;
  const std::string& digits = length->second;
  const bool number = !digits.empty() && digits.size() <= 18 &&
                      std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c); });
  if (!number) return malformed("Content-Length is not a number");
  head.length = std::stoull(digits);
  return std::nullopt;
}

std::optional<BadHead> check_fields(Head& head) {
  if (!head.http10 && !head.fields.contains("host")) return malformed("the header Host is missing");
  if (const auto expect = head.fields.find("expect"); expect != head.fields.end()) {
    if (lower(expect->second) != "100-continue") return BadHead{417, "only 100-continue can be expected"};
    head.expects_continue = !head.http10;
  }
  return read_length(head);
}

}  // namespace

std::variant<Head, BadHead> parse_head(std::string_view text) {
  Head head;
  const auto first = take_line(text);
  if (!first) return malformed("lines must end by CRLF");
  if (auto bad = read_request_line(*first, head)) return std::move(*bad);
  for (std::size_t count = 0;; ++count) {
    const auto line = take_line(text);
    if (!line) return malformed("lines must end by CRLF");
    if (line->empty()) break;
    if (count == kMaxFields) return BadHead{431, "too many header lines"};
    if (auto bad = read_field(*line, head)) return std::move(*bad);
  }
  if (auto bad = check_fields(head)) return std::move(*bad);
  return head;
}

}  // namespace photond
