#pragma once

#include <array>
#include <cmath>

#include "core/scene/scene.h"

namespace photond {

/// Linear value of each 8-bit sRGB code.
extern const std::array<float, 256> kSrgbToLinear;

/// Linear value of an sRGB value in [0, 1].
float srgb_to_linear(float encoded);

/// The texel index that coordinate `i` means in `n` texels.
inline int wrap_texel(int i, int n, Wrap wrap) {
  if (wrap == Wrap::clamp) return i < 0 ? 0 : i >= n ? n - 1 : i;
  const int period = wrap == Wrap::repeat ? n : 2 * n;
  int k = i % period;
  if (k < 0) k += period;
  return k < n ? k : 2 * n - 1 - k;
}

/// One texel, decoded to linear.
inline Vec4 fetch_texel(const TextureImage& image, bool srgb, int x, int y) {
  const std::size_t at =
      4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  if (!image.u8.empty()) {
    const std::uint8_t* p = &image.u8[at];
    if (srgb) return {kSrgbToLinear[p[0]], kSrgbToLinear[p[1]], kSrgbToLinear[p[2]], p[3] * (1 / 255.0f)};
    return Vec4(p[0], p[1], p[2], p[3]) * (1 / 255.0f);
  }
  const std::uint16_t* p = &image.u16[at];
  const Vec4 value = Vec4(p[0], p[1], p[2], p[3]) * (1 / 65535.0f);
  if (!srgb) return value;
  return {srgb_to_linear(value.x), srgb_to_linear(value.y), srgb_to_linear(value.z), value.w};
}

/// The texture at `uv`, (0,0) the upper left corner of the image, v downwards: the nearest texel or the
/// bilinear mean of the four around it, decoded to linear before filtering. A uv that is not finite reads as 0.
inline Vec4 sample_texture(const Scene& scene, const Texture& texture, Vec2 uv) {
  const TextureImage& image = scene.images[texture.image];
  // In units of texels; whole periods are taken off first, so that far coordinates keep their fraction.
  const auto place = [](float t, int n, Wrap wrap) {
    if (!std::isfinite(t)) return 0.0f;
    t = wrap == Wrap::clamp ? std::fmin(std::fmax(t, -1.0f), 2.0f) : t - 2 * std::floor(0.5f * t);
    return t * static_cast<float>(n);
  };
  float x = place(uv.x, image.width, texture.wrap_s), y = place(uv.y, image.height, texture.wrap_t);
  const auto texel = [&](int i, int j) {
    return fetch_texel(image, texture.srgb, wrap_texel(i, image.width, texture.wrap_s),
                       wrap_texel(j, image.height, texture.wrap_t));
  };
  if (texture.nearest) return texel(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
  x -= 0.5f, y -= 0.5f;
  const float fx = std::floor(x), fy = std::floor(y);
  const int i = static_cast<int>(fx), j = static_cast<int>(fy);
  const float s = x - fx, t = y - fy;
  const Vec4 top = texel(i, j) * (1 - s) + texel(i + 1, j) * s;
  const Vec4 bottom = texel(i, j + 1) * (1 - s) + texel(i + 1, j + 1) * s;
  return top * (1 - t) + bottom * t;
}

/// A texture slot at a point of a triangle of the mesh: `vertices` are indices of its corners' attributes, u and v the
/// weights of the second and third. Where the mesh has no such coordinates they are (0, 0).
inline Vec4 lookup(const Scene& scene, const TextureSlot& slot, const Mesh& mesh, const glm::uvec3& vertices, float u,
                   float v) {
  const auto& uv = mesh.uv[slot.uv_set];
  const Vec2 at = uv.empty() ? Vec2(0) : (1 - u - v) * uv[vertices.x] + u * uv[vertices.y] + v * uv[vertices.z];
  return sample_texture(scene, scene.textures[slot.texture], slot.uv_transform * Vec3(at, 1));
}

}  // namespace photond
