#include <cmath>

#include "core/film/decode.h"
#include "core/scene/gltf/build.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/uri.h"
#include "core/scene/gltf/value.h"

namespace photond::gltf {
namespace {

/// The encoded bytes of an image that is not in a buffer view.
Result<std::vector<std::byte>> external_bytes(Build& build, const tinygltf::Image& image,
                                              const std::string& where) {
  if (!image.image.empty()) {
    const auto* first = reinterpret_cast<const std::byte*>(image.image.data());
    return std::vector<std::byte>(first, first + image.image.size());
  }
  if (is_data_uri(image.uri)) return decode_data_uri(image.uri, where);
  const Result<std::string> decoded = percent_decode(image.uri, where);
  if (!decoded) return decoded.error();
  const Result<std::string> path = check_relative_path(*decoded, where);
  if (!path) return path.error();
  return build.resources(*path);
}

Result<DecodedPixels> decode_image(Build& build, const tinygltf::Image& image, const std::string& where) {
  const DecodeLimits limits{.max_side = build.limits.max_image_side,
                            .max_pixels = build.limits.max_texture_pixels - build.texture_pixels};
  if (image.bufferView >= 0) {
    const tinygltf::BufferView& view = build.model.bufferViews[image.bufferView];
    const std::span<const unsigned char> buffer = build.model.buffers[view.buffer].data;
    return decode_pixels(std::as_bytes(buffer.subspan(view.byteOffset, view.byteLength)), limits);
  }
  const Result<std::vector<std::byte>> bytes = external_bytes(build, image, where);
  if (!bytes) return bytes.error();
  return decode_pixels(*bytes, limits);
}

Wrap wrap_mode(int mode) {
  if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp;
  return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::mirror : Wrap::repeat;
}

/// The image a texture shows: WebP where the file offers it, otherwise its plain source; −1 where neither.
int texture_source(const tinygltf::Texture& texture) {
  const int webp = static_cast<int>(number(extension(texture.extensions, "EXT_texture_webp"), "source", -1));
  return webp >= 0 ? webp : texture.source;
}

Result<std::uint32_t> build_sampled_image(Build& build, int index, int source, bool srgb) {
  const auto [found, inserted] = build.textures.try_emplace({index, srgb}, 0);
  if (!inserted) return found->second;
  const tinygltf::Texture& from = build.model.textures[index];
  const Result<std::uint32_t> image = build_image(build, source);
  if (!image) return image.error();
  Texture texture{.image = *image, .srgb = srgb};
  if (from.sampler >= 0) {
    const tinygltf::Sampler& sampler = build.model.samplers[from.sampler];
    texture.wrap_s = wrap_mode(sampler.wrapS);
    texture.wrap_t = wrap_mode(sampler.wrapT);
    texture.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
  }
  found->second = static_cast<std::uint32_t>(build.scene.textures.size());
  build.scene.textures.push_back(texture);
  return found->second;
}

/// KHR_texture_transform: translation · rotation · scale. The rotation is counter-clockwise as seen, while v
/// points down, hence the sign of the sines.
Result<glm::mat3x2> read_transform(const tinygltf::Value* transform, const std::string& where) {
  const std::vector<double> offset = numbers(transform, "offset", {0, 0});
  const std::vector<double> scale = numbers(transform, "scale", {1, 1});
  const double angle = number(transform, "rotation", 0);
  for (double value : {offset[0], offset[1], scale[0], scale[1], angle}) {
    if (!(std::abs(value) <= kMaxMagnitude)) {
      return invalid_input("value is absurdly large", where + ".extensions.KHR_texture_transform");
    }
  }
  const double c = std::cos(angle), s = std::sin(angle);
  return glm::mat3x2(c * scale[0], -s * scale[0], s * scale[1], c * scale[1], offset[0], offset[1]);
}

}  // namespace

Result<std::uint32_t> build_image(Build& build, int index) {
  const auto [found, inserted] = build.images.try_emplace(index, 0);
  if (!inserted) return found->second;
  const tinygltf::Image& image = build.model.images[index];
  const std::string where = place("images", static_cast<std::size_t>(index));
  Result<DecodedPixels> pixels = decode_image(build, image, where);
  if (!pixels) return Error{pixels.error().code, pixels.error().message, where};
  build.texture_pixels +=
      static_cast<std::uint64_t>(pixels->width) * static_cast<std::uint64_t>(pixels->height);
  found->second = static_cast<std::uint32_t>(build.scene.images.size());
  build.scene.images.push_back(
      {image.name, pixels->width, pixels->height, std::move(pixels->u8), std::move(pixels->u16)});
  return found->second;
}

Result<TextureSlot> build_texture(Build& build, int texture, int tex_coord, const tinygltf::Value* transform,
                                  bool srgb, const std::string& where) {
  if (texture < 0) return TextureSlot{};
  if (Status s = check_index(texture, build.model.textures.size(), where + ".index"); !s) return s.error();
  const int source = texture_source(build.model.textures[texture]);
  if (source < 0) {
    build.warnings.add("texture has no image that can be read and is left out", where);
    return TextureSlot{};
  }
  const int uv_set = static_cast<int>(number(transform, "texCoord", tex_coord));
  if (uv_set < 0 || uv_set > 1) {
    build.warnings.add("texture uses a TEXCOORD set beyond 1 and is left out", where);
    return TextureSlot{};
  }
  const Result<std::uint32_t> sampled = build_sampled_image(build, texture, source, srgb);
  if (!sampled) return sampled.error();
  TextureSlot slot{.texture = static_cast<std::int32_t>(*sampled),
                   .uv_set = static_cast<std::uint32_t>(uv_set)};
  if (transform) {
    const Result<glm::mat3x2> matrix = read_transform(transform, where);
    if (!matrix) return matrix.error();
    slot.uv_transform = *matrix;
  }
  return slot;
}

}  // namespace photond::gltf
