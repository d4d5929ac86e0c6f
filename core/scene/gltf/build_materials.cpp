#include "core/scene/gltf/build.h"
#include "core/scene/gltf/check.h"
#include "core/scene/gltf/value.h"

namespace photond::gltf {
namespace {

constexpr const char* kTransformName = "KHR_texture_transform";

/// Reads the parts of one material; the first failure stays and the rest is skipped.
class MaterialReader {
 public:
  MaterialReader(Build& build, std::size_t index)
      : build_(build), from_(build.model.materials[index]), where_(place("materials", index)) {}

  Result<Material> read() {
    out_.name = from_.name;
    base();
    emission();
    alpha();
    ior();
    specular();
    transmission();
    volume();
    dispersion();
    anisotropy();
    clearcoat();
    sheen();
    unlit();
    if (!status_) return status_.error();
    return out_;
  }

 private:
  void base() {
    const auto& pbr = from_.pbrMetallicRoughness;
    const std::string where = where_ + ".pbrMetallicRoughness";
    out_.base_color = color(pbr.baseColorFactor);
    out_.alpha = static_cast<float>(pbr.baseColorFactor[3]);
    out_.metallic = static_cast<float>(pbr.metallicFactor);
    out_.roughness = static_cast<float>(pbr.roughnessFactor);
    out_.base_color_texture = slot(pbr.baseColorTexture, true, where + ".baseColorTexture");
    out_.metallic_roughness_texture =
        slot(pbr.metallicRoughnessTexture, false, where + ".metallicRoughnessTexture");
    out_.normal_texture = slot(from_.normalTexture, false, where_ + ".normalTexture");
    out_.normal_scale = bounded(from_.normalTexture.scale, where_ + ".normalTexture.scale");
  }

  void emission() {
    const double strength =
        number(extension(from_.extensions, "KHR_materials_emissive_strength"), "emissiveStrength", 1);
    out_.emission = color(from_.emissiveFactor) * bounded(strength, where_ + ".extensions.KHR_materials_emissive_strength.emissiveStrength");
    out_.emission_texture = slot(from_.emissiveTexture, true, where_ + ".emissiveTexture");
  }

  void alpha() {
    out_.double_sided = from_.doubleSided;
    out_.alpha_cutoff = bounded(from_.alphaCutoff, where_ + ".alphaCutoff");
    if (from_.alphaMode == "MASK") {
      out_.alpha_mode = AlphaMode::mask;
    } else if (from_.alphaMode == "BLEND") {
      out_.alpha_mode = AlphaMode::blend;
    } else if (from_.alphaMode != "OPAQUE") {
      fail("alphaMode is not one of glTF", where_ + ".alphaMode");
    }
  }

  void ior() {
    const double value = number(extension(from_.extensions, "KHR_materials_ior"), "ior", 1.5);
    const std::string where = where_ + ".extensions.KHR_materials_ior.ior";
    if (value != 0 && value < 1) fail("ior must be 0 or at least 1", where);
    out_.ior = bounded(value, where);
  }

  void specular() {
    const tinygltf::Value* from = extension(from_.extensions, "KHR_materials_specular");
    const std::string where = where_ + ".extensions.KHR_materials_specular";
    out_.specular = static_cast<float>(number(from, "specularFactor", 1));
    out_.specular_color = color(numbers(from, "specularColorFactor", {1, 1, 1}));
    out_.specular_texture = slot(member(from, "specularTexture"), false, where + ".specularTexture");
    out_.specular_color_texture =
        slot(member(from, "specularColorTexture"), true, where + ".specularColorTexture");
    bounded(max_component(out_.specular_color), where + ".specularColorFactor");
  }

  void transmission() {
    const tinygltf::Value* from = extension(from_.extensions, "KHR_materials_transmission");
    out_.transmission = static_cast<float>(number(from, "transmissionFactor", 0));
    out_.transmission_texture = slot(member(from, "transmissionTexture"), false,
                                     where_ + ".extensions.KHR_materials_transmission.transmissionTexture");
  }

  void volume() {
    const tinygltf::Value* from = extension(from_.extensions, "KHR_materials_volume");
    out_.thin_walled = !(number(from, "thicknessFactor", 0) > 0);
    out_.attenuation_color = color(numbers(from, "attenuationColor", {1, 1, 1}));
    if (!member(from, "attenuationDistance")) return;
    const double distance = number(from, "attenuationDistance", 0);
    const std::string where = where_ + ".extensions.KHR_materials_volume.attenuationDistance";
    if (!(distance > 0)) return fail("attenuationDistance must be positive", where);
    // Exporters write the largest float for "no attenuation"; beyond any scene's size it means the same.
    if (distance < kMaxMagnitude) out_.attenuation_distance = static_cast<float>(distance);
  }

  void dispersion() {
    const tinygltf::Value* from = extension(from_.extensions, "KHR_materials_dispersion");
    out_.dispersion = bounded(number(from, "dispersion", 0), where_ + ".extensions.KHR_materials_dispersion.dispersion");
  }

  void anisotropy() {
    const tinygltf::Value* from = extension(from_.extensions, "KHR_materials_anisotropy");
    const std::string where = where_ + ".extensions.KHR_materials_anisotropy";
    out_.anisotropy = static_cast<float>(number(from, "anisotropyStrength", 0));
    out_.anisotropy_rotation = bounded(number(from, "anisotropyRotation", 0), where + ".anisotropyRotation");
    if (out_.anisotropy == 0) return;
    out_.anisotropy_texture = slot(member(from, "anisotropyTexture"), false, where + ".anisotropyTexture");
  }

  void clearcoat() {
    const tinygltf::Value* from = extension(from_.extensions, "KHR_materials_clearcoat");
    const std::string where = where_ + ".extensions.KHR_materials_clearcoat";
    out_.clearcoat = static_cast<float>(number(from, "clearcoatFactor", 0));
    if (out_.clearcoat == 0) return;
    out_.clearcoat_texture = slot(member(from, "clearcoatTexture"), false, where + ".clearcoatTexture");
    out_.clearcoat_roughness = static_cast<float>(number(from, "clearcoatRoughnessFactor", 0));
    out_.clearcoat_roughness_texture =
        slot(member(from, "clearcoatRoughnessTexture"), false, where + ".clearcoatRoughnessTexture");
    const tinygltf::Value* normal = member(from, "clearcoatNormalTexture");
    out_.clearcoat_normal_texture = slot(normal, false, where + ".clearcoatNormalTexture");
    out_.clearcoat_normal_scale = bounded(number(normal, "scale", 1), where + ".clearcoatNormalTexture.scale");
    if (out_.emissive()) build_.warnings.add("what a material emits is not dimmed by its clear coat", where_);
  }

  void sheen() {
    const tinygltf::Value* from = extension(from_.extensions, "KHR_materials_sheen");
    const std::string where = where_ + ".extensions.KHR_materials_sheen";
    out_.sheen_color = color(numbers(from, "sheenColorFactor", {0, 0, 0}));
    if (!out_.sheened()) return;
    out_.sheen_color_texture = slot(member(from, "sheenColorTexture"), true, where + ".sheenColorTexture");
    out_.sheen_roughness = static_cast<float>(number(from, "sheenRoughnessFactor", 0));
    out_.sheen_roughness_texture =
        slot(member(from, "sheenRoughnessTexture"), false, where + ".sheenRoughnessTexture");
  }

  void unlit() {
    if (!extension(from_.extensions, "KHR_materials_unlit")) return;
    build_.warnings.add("KHR_materials_unlit is shown as a diffuse surface under the scene's light", where_);
    out_.metallic = 0;
    out_.roughness = 1;
    out_.specular = 0;
    out_.clearcoat = 0;
    out_.sheen_color = Rgb(0);
  }

  template <class Info>
  TextureSlot slot(const Info& info, bool srgb, const std::string& where) {
    return slot(info.index, info.texCoord, extension(info.extensions, kTransformName), srgb, where);
  }
  TextureSlot slot(const tinygltf::Value* info, bool srgb, const std::string& where) {
    return slot(static_cast<int>(number(info, "index", -1)), static_cast<int>(number(info, "texCoord", 0)),
                member(member(info, "extensions"), kTransformName), srgb, where);
  }
  TextureSlot slot(int texture, int tex_coord, const tinygltf::Value* transform, bool srgb,
                   const std::string& where) {
    if (!status_) return {};
    Result<TextureSlot> result = build_texture(build_, texture, tex_coord, transform, srgb, where);
    if (result) return *result;
    status_ = result.error();
    return {};
  }

  static Rgb color(const std::vector<double>& values) { return Rgb(values[0], values[1], values[2]); }

  float bounded(double value, const std::string& where) {
    if (!(value >= -kMaxMagnitude && value <= kMaxMagnitude)) fail("value is absurdly large", where);
    return static_cast<float>(value);
  }

  void fail(std::string message, const std::string& where) {
    if (status_) status_ = invalid_input(std::move(message), where);
  }

  Build& build_;
  const tinygltf::Material& from_;
  std::string where_;
  Material out_;
  Status status_ = Done{};
};

}  // namespace

Status build_materials(Build& build) {
  for (std::size_t i = 0; i < build.model.materials.size(); ++i) {
    Result<Material> material = MaterialReader(build, i).read();
    if (!material) return material.error();
    build.scene.materials.push_back(std::move(*material));
  }
  return Done{};
}

}  // namespace photond::gltf
