#pragma once

#include <string>

namespace photond {

/// What a picture's file says of how it was made, for whoever sees it without its job: that its method is biased. Empty
/// where there is nothing to say.
inline std::string picture_note(const std::string& method, bool biased) {
  return biased ? "photond " + method + ": biased, does not converge to the exact picture" : std::string();
}

}  // namespace photond
