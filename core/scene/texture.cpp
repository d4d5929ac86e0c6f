#include "core/scene/texture.h"

namespace photond {
namespace {

std::array<float, 256> make_table() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = srgb_to_linear(static_cast<float>(i) / 255.0f);
  return table;
}

}  // namespace

float srgb_to_linear(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

const std::array<float, 256> kSrgbToLinear = make_table();

}  // namespace photond
