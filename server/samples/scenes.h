#pragma once

#include "glb.h"

namespace photond::samples {

/// Two boxes in a diffuse room with coloured walls.
Glb cornell_box();
/// A glass and a mirror sphere under a small light: caustics, reflected and refracted.
Glb glass_and_mirror();
/// Ripples on a tiled pool in the sun: caustics seen through the water that makes them.
Glb pool();
/// A lamp in a shell of glass: all light of the room has passed two glass surfaces.
Glb lantern();

/// An open-fronted room from (−1, 0, −1) to (1, 2, 1); walls face inwards.
void add_room(Glb& glb, const Rgb& left, const Rgb& right, const Rgb& rest);

}  // namespace photond::samples
