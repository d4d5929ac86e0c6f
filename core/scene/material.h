#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/base/features.h"
#include "core/math/types.h"

namespace photond {

/// How one texture is applied; `texture` < 0 means none.
struct TextureSlot {
  std::int32_t texture = -1;                             ///< index into Scene::textures
  std::uint32_t uv_set = 0;                              ///< 0 or 1
  glm::mat3x2 uv_transform{1, 0, 0, 1, 0, 0};            ///< KHR_texture_transform: uv' = M·(u, v, 1)

  bool used() const { return kAllFeatures && texture >= 0; }
};

enum class AlphaMode : std::uint8_t { opaque, mask, blend };

/// A glTF 2.0 metallic-roughness material with the extensions named beside the fields. Plain data.
struct Material {
  std::string name;

  Rgb base_color{1};
  float alpha = 1;
  TextureSlot base_color_texture;                        ///< sRGB, times COLOR_0 where the mesh has it
  float metallic = 1;
  float roughness = 1;                                   ///< perceptual; GGX α = roughness²
  TextureSlot metallic_roughness_texture;                ///< linear: G roughness, B metallic
  TextureSlot normal_texture;                            ///< linear, tangent space
  float normal_scale = 1;
  Rgb emission{0};                                       ///< radiance: emissiveFactor × emissiveStrength
  TextureSlot emission_texture;                          ///< sRGB
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;                             ///< emission leaves the back too

  float ior = 1.5f;                                      ///< KHR_materials_ior; 0 means F = 1 everywhere
  float specular = 1;                                    ///< KHR_materials_specular
  TextureSlot specular_texture;                          ///< linear A
  Rgb specular_color{1};
  TextureSlot specular_color_texture;                    ///< sRGB
  float transmission = 0;                                ///< KHR_materials_transmission
  TextureSlot transmission_texture;                      ///< linear R
  bool thin_walled = true;                               ///< KHR_materials_volume: thicknessFactor is 0
  Rgb attenuation_color{1};
  float attenuation_distance = kInfinity;                ///< metres
  bool nested = false;                                   ///< set by `prepare`: volumes of it may lie within others (find_nested)
  float dispersion = 0;                                  ///< KHR_materials_dispersion: 20 over Abbe's number
  float anisotropy = 0;                                  ///< KHR_materials_anisotropy: strength
  float anisotropy_rotation = 0;                         ///< from the tangent to where highlights are longest, radians
  TextureSlot anisotropy_texture;                        ///< linear: RG that direction before it is turned, B strength
  float clearcoat = 0;                                   ///< KHR_materials_clearcoat: amount of the layer on top
  TextureSlot clearcoat_texture;                         ///< linear R
  float clearcoat_roughness = 0;                         ///< perceptual
  TextureSlot clearcoat_roughness_texture;               ///< linear G
  TextureSlot clearcoat_normal_texture;                  ///< as normal_texture, which does not bend the coat
  float clearcoat_normal_scale = 1;
  Rgb sheen_color{0};                                    ///< KHR_materials_sheen: fibres between coat and base
  TextureSlot sheen_color_texture;                       ///< sRGB
  float sheen_roughness = 0;                             ///< perceptual
  TextureSlot sheen_roughness_texture;                   ///< linear A

  bool emissive() const { return !is_black(emission); }
  /// Where it emits, every place does alike.
  bool shines_evenly() const {
    return !emission_texture.used() && (!kAllFeatures || alpha_mode == AlphaMode::opaque);
  }
  /// A Lambert surface without a layer, whatever textures say.
  bool bare_diffuse() const {
    return metallic == 0 && specular == 0 && transmission == 0 && clearcoat == 0 && !sheened();
  }
  bool sheened() const { return !is_black(sheen_color); }
  /// Whether a texture bends any of its normals.
  bool bends_normals() const { return normal_texture.used() || clearcoat_normal_texture.used(); }
};

/// All that a material may have.
inline std::array<const TextureSlot*, 13> texture_slots(const Material& m) {
  return {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emission_texture,
          &m.specular_texture, &m.specular_color_texture, &m.transmission_texture, &m.clearcoat_texture,
          &m.clearcoat_roughness_texture, &m.clearcoat_normal_texture, &m.sheen_color_texture,
          &m.sheen_roughness_texture, &m.anisotropy_texture};
}

}  // namespace photond
