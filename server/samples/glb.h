#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "shapes.h"

namespace photond::samples {

/// Collects meshes, materials and cameras and writes them as one GLB.
class Glb {
 public:
  explicit Glb(const std::string& title);

  // Materials; each returns its index.
  int lambert(const std::string& name, const Rgb& reflectance);
  int metal(const std::string& name, const Rgb& reflectance, float roughness);
  int glossy(const std::string& name, const Rgb& color, float roughness);
  int glass(const std::string& name, float ior, const Rgb& attenuation, float attenuation_distance);
  /// Shines from its front with the given radiance.
  int emitter(const std::string& name, const Rgb& radiance);

  /// A mesh with one node of the same name.
  void add(const std::string& name, const Shape& shape, int material);
  void add_camera(const std::string& name, const Vec3& eye, const Vec3& target, float yfov,
                  const Vec3& up = Vec3(0, 1, 0));

  /// The finished file.
  std::string bytes() const;

 private:
  int add_material(nlohmann::json material);
  int add_view(const void* data, std::size_t size, int target);
  int add_vec3(const std::vector<Vec3>& values, bool with_range);
  int add_indices(const std::vector<glm::uvec3>& triangles);
  void use_extension(const std::string& name);
  void add_node(nlohmann::json node);

  nlohmann::json json_;
  std::string bin_;
};

}  // namespace photond::samples
