#pragma once

#include <cstdint>

namespace photond {

/// Bytes of memory that this process may have: the machine's, or what its control group (v2) is given, whichever is
/// less.
std::uint64_t machine_memory();

}  // namespace photond
