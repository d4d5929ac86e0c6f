#pragma once

#include <cstddef>

#include "core/scene/scene.h"

namespace photond {

/// Holds surfaces apart that coincide with glass. A ray that goes on behind a surface begins a little beyond it, and would
/// jump over what lies there: the liquid in its cup, the table below a block of glass. So the triangles of a mesh that
/// transmits are moved where they lie in the plane of another's: volumes into one another, as if in optical contact;
/// volumes away from anything opaque, with a gap, as dry glass on a table; thin sheets to the other's front. The way is
/// some units in the last place of the coordinates. Meshes must have been placed, their vertices not been made. Returns
/// how many placed triangles of glass were found to lie so; in a scene without glass none is looked at.
std::size_t separate_touching(Scene& scene);

}  // namespace photond
