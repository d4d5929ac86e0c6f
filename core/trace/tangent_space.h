#pragma once

#include <optional>

#include "core/trace/surface.h"

namespace photond {

/// The directions in which a texture's first and second number of a tangent-space vector point: unit, world, orthogonal
/// to the normal of the front face and to each other.
struct TangentSpace {
  Vec3 tangent;
  Vec3 bitangent;
};

/// By the mesh's tangents or, without any, by the gradient of the slot's texture coordinates; nothing where neither tells.
/// `n`: unit normal of the front face.
std::optional<TangentSpace> tangent_space(const Scene& scene, const SurfacePoint& s, const TextureSlot& slot,
                                          const Vec3& n);

}  // namespace photond
