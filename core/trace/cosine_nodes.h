#pragma once

#include <algorithm>
#include <cmath>

#include "core/math/float8.h"

namespace photond {

/// A function of a cosine in [0, 1] by its values at nodes, which lie denser at grazing angles, where what layers
/// reflect varies fastest; linear between them.
struct CosineNodes {
  static constexpr int kCount = 32;
  alignas(32) float value[kCount];

  static float cosine(int node) {
    const float s = static_cast<float>(node) / (kCount - 1);
    return s * s;
  }
  /// The node below a cosine, and how far it is on the way to the next.
  static int cell(float cosine, float& part) {
    const float s = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * (kCount - 1);
    const int node = std::min(static_cast<int>(s), kCount - 2);
    part = s - static_cast<float>(node);
    return node;
  }

  float operator()(float cosine) const {
    float part = 0;
    const int node = cell(cosine, part);
    return value[node] + part * (value[node + 1] - value[node]);
  }
  Float8 operator()(const Float8& cosine) const {
    const Float8 s = sqrt8(min8(max8(cosine, Float8{}), Float8{} + 1)) * (kCount - 1);
    const Mask8 below = __builtin_convertvector(s, Mask8);
    const Mask8 node = below < kCount - 2 ? below : Mask8{} + (kCount - 2);
    const Float8 low = lookup8(value, node), high = lookup8(value + 1, node);
    return low + (s - __builtin_convertvector(node, Float8)) * (high - low);
  }
};

}  // namespace photond
