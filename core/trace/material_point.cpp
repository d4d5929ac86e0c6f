// glTF 2.0, §3.9, and the extensions named in Material.
#include "core/trace/material_point.h"

#include <cmath>

namespace photond {

Rgb base_color_at(const Scene& scene, const SurfacePoint& s) {
  const Material& m = *s.material;
  Rgb color = m.base_color;
  if (!s.mesh->colors.empty()) {
    const auto& c = s.mesh->colors;
    color *= Rgb((1 - s.u - s.v) * c[s.vertices.x] + s.u * c[s.vertices.y] + s.v * c[s.vertices.z]);
  }
  if (m.base_color_texture.used()) color *= Rgb(lookup(scene, m.base_color_texture, s));
  return color;
}

namespace {

void set_anisotropy(const Scene& scene, const SurfacePoint& s, MaterialPoint& p) {
  const Material& m = *s.material;
  Vec2 direction(1, 0);
  if (m.anisotropy_texture.used()) {
    const Vec4 texel = lookup(scene, m.anisotropy_texture, s);
    direction = 2.0f * Vec2(texel) - Vec2(1);
    p.anisotropy *= texel.z;
  }
  const float sine = std::sin(m.anisotropy_rotation), cosine = std::cos(m.anisotropy_rotation);
  p.anisotropy_direction = {cosine * direction.x - sine * direction.y, sine * direction.x + cosine * direction.y};
}

}  // namespace

MaterialPoint material_at(const Scene& scene, const SurfacePoint& s) {
  const Material& m = *s.material;
  MaterialPoint p{base_color_at(scene, s), m.metallic,     m.roughness,  m.specular,  m.specular_color,
                  m.transmission,          m.anisotropy,   Vec2(1, 0),   m.clearcoat, m.clearcoat_roughness,
                  m.sheen_color,           m.sheen_roughness};
  if (m.metallic_roughness_texture.used()) {
    const Vec4 texel = lookup(scene, m.metallic_roughness_texture, s);
    p.roughness *= texel.y;
    p.metallic *= texel.z;
  }
  if (m.specular_texture.used()) p.specular *= lookup(scene, m.specular_texture, s).w;
  if (m.specular_color_texture.used()) p.specular_color *= Rgb(lookup(scene, m.specular_color_texture, s));
  if (m.transmission_texture.used()) p.transmission *= lookup(scene, m.transmission_texture, s).x;
  if (m.anisotropy > 0) set_anisotropy(scene, s, p);
  if (m.clearcoat_texture.used()) p.clearcoat *= lookup(scene, m.clearcoat_texture, s).x;
  if (m.clearcoat_roughness_texture.used()) p.clearcoat_roughness *= lookup(scene, m.clearcoat_roughness_texture, s).y;
  if (m.sheen_color_texture.used()) p.sheen_color *= Rgb(lookup(scene, m.sheen_color_texture, s));
  if (m.sheen_roughness_texture.used()) p.sheen_roughness *= lookup(scene, m.sheen_roughness_texture, s).w;
  return p;
}

}  // namespace photond
