#pragma once

#include "core/scene/scene.h"

namespace photond {

/// Marks the materials of volumes that may reach into another one, by the boxes around them in the world
/// (Material::nested): where light passes from glass into a liquid, both indices must be known.
void find_nested(Scene& scene);

}  // namespace photond
