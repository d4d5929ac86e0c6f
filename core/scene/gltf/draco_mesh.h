#pragma once

#include <draco/mesh/mesh.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/result.h"

namespace photond::gltf {

/// Decodes a mesh in Draco's bitstream 2.2. Its faces and points are counted before there is memory for them: decoding
/// takes no more than about `max_bytes`. Of the mesh nothing is checked: faces may name points that it has not.
Result<std::unique_ptr<draco::Mesh>> decode_draco_mesh(std::span<const unsigned char> data, std::uint64_t max_bytes,
                                                       const std::string& where);

}  // namespace photond::gltf
