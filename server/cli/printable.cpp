#include "server/cli/printable.h"

#include <cstddef>

namespace photond {

std::string printable(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c < 0x20 || c == 0x7F) text[i] = c == '\n' || c == '\t' ? ' ' : '?';
    // U+0080 to U+009F in UTF-8; terminals obey these, too.
    if (c == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0) text.replace(i, 2, "?");
  }
  return text;
}

}  // namespace photond
