#pragma once

#include <string>

namespace photond::test {

/// A GLB of a floor below a square lamp, with the cameras "front" and "above"; `name` goes into the file, so
/// that different names give different files of equal content.
std::string small_glb(const std::string& name = "small");

/// The same as JSON text whose buffer is the file `quad.bin` (its bytes in `quad_bin`).
std::string small_gltf();
std::string quad_bin();

}  // namespace photond::test
