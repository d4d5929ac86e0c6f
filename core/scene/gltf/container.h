#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "core/base/result.h"

namespace photond::gltf {

/// The parts of a glTF file in memory.
struct Container {
  bool binary = false;  ///< GLB
  std::string_view json;
  std::span<const std::byte> bin;  ///< GLB chunk 1; may be empty
};

/// Tells GLB from JSON by the first bytes and checks the GLB header and chunk layout.
Result<Container> open_container(std::span<const std::byte> bytes);

}  // namespace photond::gltf
