#include "core/scene/gltf/json_text.h"

#include <cstdint>

namespace photond::gltf {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

void append_utf8(std::string& out, unsigned code) {
  const auto put = [&out](unsigned byte) { out.push_back(static_cast<char>(byte)); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xC0 | code >> 6);
    put(0x80 | (code & 63));
  } else if (code < 0x10000) {
    put(0xE0 | code >> 12);
    put(0x80 | (code >> 6 & 63));
    put(0x80 | (code & 63));
  } else {
    put(0xF0 | code >> 18);
    put(0x80 | (code >> 12 & 63));
    put(0x80 | (code >> 6 & 63));
    put(0x80 | (code & 63));
  }
}

}  // namespace

void JsonText::skip_space() {
  while (!at_end() && (peek() == ' ' || peek() == '\t' || peek() == '\n' || peek() == '\r')) take();
}

bool JsonText::accept(char c) {
  if (at_end() || peek() != c) return false;
  take();
  return true;
}

bool JsonText::accept_word(std::string_view word) {
  if (text_.substr(at_, word.size()) != word) return false;
  at_ += word.size();
  return true;
}

std::optional<std::string_view> JsonText::read_string(std::string* out) {
  take();
  while (!at_end()) {
    const auto c = static_cast<unsigned char>(peek());
    if (c == '"') {
      take();
      return std::nullopt;
    }
    if (c == '\\') {
      take();
      if (auto problem = read_escape(out)) return problem;
      continue;
    }
    if (c < 0x20) return "control character in a string";
    const std::size_t length = utf8_length();
    if (length == 0) return "invalid UTF-8";
    if (out) out->append(text_.substr(at_, length));
    at_ += length;
  }
  return "unterminated string";
}

std::optional<std::string_view> JsonText::read_escape(std::string* out) {
  constexpr std::string_view kNames = "\"\\/bfnrt";
  constexpr std::string_view kValues = "\"\\/\b\f\n\r\t";
  if (at_end()) return "unterminated string";
  const char c = peek();
  take();
  if (const auto i = kNames.find(c); i != std::string_view::npos) {
    if (out) out->push_back(kValues[i]);
    return std::nullopt;
  }
  unsigned code = 0;
  if (c != 'u' || !read_hex4(code)) return "invalid escape";
  if (code >= 0xDC00 && code < 0xE000) return "unpaired surrogate";
  if (code >= 0xD800 && code < 0xDC00) {
    unsigned low = 0;
    if (!accept_word("\\u") || !read_hex4(low) || low < 0xDC00 || low > 0xDFFF) return "unpaired surrogate";
    code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
  }
  if (out) append_utf8(*out, code);
  return std::nullopt;
}

bool JsonText::read_hex4(unsigned& code) {
  code = 0;
  for (int i = 0; i < 4; ++i) {
    if (at_end()) return false;
    const char c = peek();
    const int digit = is_digit(c)              ? c - '0'
                      : (c >= 'a' && c <= 'f') ? c - 'a' + 10
                      : (c >= 'A' && c <= 'F') ? c - 'A' + 10
                                               : -1;
    if (digit < 0) return false;
    code = code * 16 + static_cast<unsigned>(digit);
    take();
  }
  return true;
}

bool JsonText::read_digits() {
  const std::size_t start = at_;
  while (!at_end() && is_digit(peek())) take();
  return at_ != start;
}

std::string_view JsonText::read_number(bool& integral) {
  const std::size_t start = at_;
  integral = true;
  accept('-');
  const std::size_t first = at_;
  if (!read_digits()) return {};
  if (text_[first] == '0' && at_ - first > 1) return {};
  if (accept('.')) {
    integral = false;
    if (!read_digits()) return {};
  }
  if (accept('e') || accept('E')) {
    integral = false;
    if (!accept('+')) accept('-');
    if (!read_digits()) return {};
  }
  return text_.substr(start, at_ - start);
}

/// Length of the well-formed UTF-8 sequence at the cursor (Unicode table 3-7), 0 where it is not one.
std::size_t JsonText::utf8_length() const {
  const auto byte = [this](std::size_t i) -> unsigned {
    return at_ + i < text_.size() ? static_cast<unsigned char>(text_[at_ + i]) : 0u;
  };
  const auto tail = [&byte](std::size_t i) { return (byte(i) & 0xC0) == 0x80; };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead <= 0xDF) return tail(1) ? 2 : 0;
  if (lead >= 0xE0 && lead <= 0xEF) {
    const bool overlong = lead == 0xE0 && byte(1) < 0xA0;
    const bool surrogate = lead == 0xED && byte(1) > 0x9F;
    return tail(1) && tail(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (lead >= 0xF0 && lead <= 0xF4) {
    const bool overlong = lead == 0xF0 && byte(1) < 0x90;
    const bool beyond = lead == 0xF4 && byte(1) > 0x8F;
    return tail(1) && tail(2) && tail(3) && !overlong && !beyond ? 4 : 0;
  }
  return 0;
}

}  // namespace photond::gltf
