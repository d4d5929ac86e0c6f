#pragma once

#include <string>

namespace photond {

/// `text` with a question mark for each control character, and spaces for line ends: names in a file must not steer the
/// terminal that shows them.
std::string printable(std::string text);

}  // namespace photond
