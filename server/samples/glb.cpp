#include "glb.h"

#include <algorithm>
#include <cstring>
#include <glm/gtc/quaternion.hpp>

namespace photond::samples {
namespace {

using nlohmann::json;

constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kFloat = 5126, kUnsignedInt = 5125;

json to_json(const Vec3& v) { return {v.x, v.y, v.z}; }

void put_u32(std::string& out, std::size_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<char>(value >> (8 * i) & 0xFF));
}

void put_chunk(std::string& out, const char* type, std::string data, char padding) {
  data.resize((data.size() + 3) / 4 * 4, padding);
  put_u32(out, data.size());
  out.append(type, 4);
  out += data;
}

json metallic_roughness(const Rgb& color, float metallic, float roughness) {
  return {{"baseColorFactor", {color.r, color.g, color.b, 1}},
          {"metallicFactor", metallic},
          {"roughnessFactor", roughness}};
}

}  // namespace

Glb::Glb(const std::string& title) {
  json_ = {{"asset", {{"version", "2.0"}, {"generator", "photond_samples"}}},
           {"scene", 0},
           {"scenes", json::array({{{"name", title}, {"nodes", json::array()}}})},
           {"nodes", json::array()},
           {"meshes", json::array()},
           {"materials", json::array()},
           {"cameras", json::array()},
           {"accessors", json::array()},
           {"bufferViews", json::array()},
           {"extensionsUsed", json::array()}};
}

int Glb::lambert(const std::string& name, const Rgb& reflectance) {
  use_extension("KHR_materials_specular");
  return add_material({{"name", name},
                       {"pbrMetallicRoughness", metallic_roughness(reflectance, 0, 1)},
                       {"extensions", {{"KHR_materials_specular", {{"specularFactor", 0}}}}}});
}

int Glb::metal(const std::string& name, const Rgb& reflectance, float roughness) {
  return add_material(
      {{"name", name}, {"pbrMetallicRoughness", metallic_roughness(reflectance, 1, roughness)}});
}

int Glb::glossy(const std::string& name, const Rgb& color, float roughness) {
  return add_material({{"name", name}, {"pbrMetallicRoughness", metallic_roughness(color, 0, roughness)}});
}

int Glb::glass(const std::string& name, float ior, const Rgb& attenuation, float attenuation_distance) {
  for (const char* used : {"KHR_materials_ior", "KHR_materials_transmission", "KHR_materials_volume"}) {
    use_extension(used);
  }
  json volume = {{"thicknessFactor", 1}};
  if (attenuation != Rgb(1)) {
    volume["attenuationColor"] = to_json(attenuation);
    volume["attenuationDistance"] = attenuation_distance;
  }
  return add_material({{"name", name},
                       {"pbrMetallicRoughness", metallic_roughness(Rgb(1), 0, 0)},
                       {"extensions",
                        {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                         {"KHR_materials_ior", {{"ior", ior}}},
                         {"KHR_materials_volume", volume}}}});
}

int Glb::emitter(const std::string& name, const Rgb& radiance) {
  use_extension("KHR_materials_emissive_strength");
  use_extension("KHR_materials_specular");
  const float strength = max_component(radiance);
  return add_material({{"name", name},
                       {"pbrMetallicRoughness", metallic_roughness(Rgb(0), 0, 1)},
                       {"emissiveFactor", to_json(radiance / strength)},
                       {"extensions",
                        {{"KHR_materials_emissive_strength", {{"emissiveStrength", strength}}},
                         {"KHR_materials_specular", {{"specularFactor", 0}}}}}});
}

void Glb::add(const std::string& name, const Shape& shape, int material) {
  json attributes = {{"POSITION", add_vec3(shape.positions, true)}};
  if (!shape.normals.empty()) attributes["NORMAL"] = add_vec3(shape.normals, false);
  const json primitive = {
      {"attributes", attributes}, {"indices", add_indices(shape.triangles)}, {"material", material}};
  json_["meshes"].push_back({{"name", name}, {"primitives", json::array({primitive})}});
  add_node({{"name", name}, {"mesh", json_["meshes"].size() - 1}});
}

void Glb::add_camera(const std::string& name, const Vec3& eye, const Vec3& target, float yfov, const Vec3& up) {
  const glm::dvec3 back = glm::normalize(glm::dvec3(eye - target));
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(up), back));
  const glm::dquat q = glm::normalize(glm::quat_cast(glm::dmat3(right, glm::cross(back, right), back)));
  json_["cameras"].push_back({{"name", name},
                              {"type", "perspective"},
                              {"perspective", {{"yfov", yfov}, {"znear", 0.01}, {"zfar", 100}}}});
  add_node({{"name", name},
            {"camera", json_["cameras"].size() - 1},
            {"translation", to_json(eye)},
            {"rotation", {q.x, q.y, q.z, q.w}}});
}

std::string Glb::bytes() const {
  json document = json_;
  document["buffers"] = json::array({{{"byteLength", bin_.size()}}});
  std::string chunks;
  put_chunk(chunks, "JSON", document.dump(), ' ');
  put_chunk(chunks, "BIN\0", bin_, '\0');
  std::string out = "glTF";
  put_u32(out, 2);
  put_u32(out, 12 + chunks.size());
  return out + chunks;
}

int Glb::add_material(json material) {
  json_["materials"].push_back(std::move(material));
  return static_cast<int>(json_["materials"].size()) - 1;
}

int Glb::add_view(const void* data, std::size_t size, int target) {
  json_["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", bin_.size()}, {"byteLength", size}, {"target", target}});
  bin_.append(static_cast<const char*>(data), size);
  return static_cast<int>(json_["bufferViews"].size()) - 1;
}

int Glb::add_vec3(const std::vector<Vec3>& values, bool with_range) {
  json accessor = {{"bufferView", add_view(values.data(), values.size() * sizeof(Vec3), kArrayBuffer)},
                   {"componentType", kFloat},
                   {"count", values.size()},
                   {"type", "VEC3"}};
  if (with_range) {
    Bounds3 bounds;
    for (const Vec3& value : values) bounds.add(value);
    accessor["min"] = to_json(bounds.min);
    accessor["max"] = to_json(bounds.max);
  }
  json_["accessors"].push_back(std::move(accessor));
  return static_cast<int>(json_["accessors"].size()) - 1;
}

int Glb::add_indices(const std::vector<glm::uvec3>& triangles) {
  const int view = add_view(triangles.data(), triangles.size() * sizeof(glm::uvec3), kElementArrayBuffer);
  json_["accessors"].push_back({{"bufferView", view},
                                {"componentType", kUnsignedInt},
                                {"count", 3 * triangles.size()},
                                {"type", "SCALAR"}});
  return static_cast<int>(json_["accessors"].size()) - 1;
}

void Glb::use_extension(const std::string& name) {
  json& used = json_["extensionsUsed"];
  if (std::find(used.begin(), used.end(), json(name)) == used.end()) used.push_back(name);
}

void Glb::add_node(json node) {
  json_["nodes"].push_back(std::move(node));
  json_["scenes"][0]["nodes"].push_back(json_["nodes"].size() - 1);
}

}  // namespace photond::samples
