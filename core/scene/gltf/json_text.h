#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace photond::gltf {

/// A cursor over JSON text that recognises the tokens of RFC 8259.
class JsonText {
 public:
  explicit JsonText(std::string_view text) : text_(text) {}

  bool at_end() const { return at_ == text_.size(); }
  std::size_t position() const { return at_; }
  char peek() const { return text_[at_]; }
  void take() { ++at_; }
  void skip_space();
  /// Skips `c` if it is next.
  bool accept(char c);
  /// Skips `word` if it is next.
  bool accept_word(std::string_view word);
  /// Reads a string token including its quotes; appends the decoded text to `out` unless that is null.
  /// Returns what is wrong with it, or nothing.
  std::optional<std::string_view> read_string(std::string* out);
  /// Reads a number token; empty where there is none. `integral`: neither fraction nor exponent.
  std::string_view read_number(bool& integral);

 private:
  std::optional<std::string_view> read_escape(std::string* out);
  bool read_hex4(unsigned& code);
  bool read_digits();
  std::size_t utf8_length() const;

  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace photond::gltf
