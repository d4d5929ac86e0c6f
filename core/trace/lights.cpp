#include "core/trace/lights.h"

#include <cmath>
#include <numeric>

#include "core/math/frame.h"
#include "core/math/transform.h"
#include "core/math/warp.h"

namespace photond {

namespace {

constexpr std::uint32_t kNoLight = 0xffffffff;
// Share of the choices that ignores power: a light of no estimated power still gets its turn.
constexpr double kFloor = 0.05;

double mean(const Rgb& c) { return (static_cast<double>(c.x) + c.y + c.z) / 3; }

EmitterTriangle emitter_triangle(const Scene& scene, std::uint32_t instance, std::uint32_t triangle) {
  const TriangleVertices world = triangle_vertices(scene, instance, triangle);
  EmitterTriangle emitter{world.a, world.b - world.a, world.c - world.a, {0, 0, 1}, 0, 0, 0, 0};
  const Vec3 normal = glm::cross(emitter.ab, emitter.ac);
  const float length = glm::length(normal);
  if (length > 0) emitter.normal = normal / length;
  emitter.area = 0.5f * length;
  for (const Vec3& p : {world.a, world.b, world.c}) {
    emitter.extent = std::max(emitter.extent, max_component(glm::abs(p)));
  }
  emitter.material = scene.meshes[scene.instances[instance].mesh].material;
  return emitter;
}

// glTF's cone attenuation: the square of the cosine's position between outer and inner angle.
float spot_attenuation(const PunctualLight& light, float cos_angle) {
  if (light.type != LightType::spot) return 1;
  const float range = std::max(light.cos_inner - light.cos_outer, 1e-4f);
  const float t = std::clamp((cos_angle - light.cos_outer) / range, 0.0f, 1.0f);
  return t * t;
}

double punctual_power(const PunctualLight& light, double disc_radius) {
  const double intensity = mean(light.intensity);
  switch (light.type) {
    case LightType::point:
      return 4 * kPi * intensity;
    case LightType::spot:
      return 2 * kPi * intensity * ((1 - light.cos_inner) + (light.cos_inner - light.cos_outer) / 3.0);
    case LightType::directional:
      return kPi * disc_radius * disc_radius * intensity;
  }
  return 0;
}

DirectSample sample_punctual(const PunctualLight& light, const Vec3& point, float choice) {
  DirectSample sample;
  if (light.type == LightType::directional) {
    sample.wi = -light.direction;
    sample.radiance = light.intensity / choice;
    sample.infinite = true;
    return sample;
  }
  const Vec3 to_light = light.position - point;
  const float distance_sq = glm::dot(to_light, to_light);
  if (!(distance_sq > 0)) return {};
  sample.wi = to_light / std::sqrt(distance_sq);
  const float attenuation = spot_attenuation(light, -glm::dot(light.direction, sample.wi));
  sample.radiance = light.intensity * (attenuation / (distance_sq * choice));
  sample.target = light.position;
  return sample;
}

// A ray towards the disc of the scene's bounding sphere that faces `direction`.
Ray ray_from_infinity(const Vec3& center, float radius, const Vec3& direction, const Vec2& u) {
  const Frame frame(direction);
  const Vec2 d = square_to_disk(u) * radius;
  // Twice the radius away: outside the sphere whatever rounding does.
  return {center + d.x * frame.s + d.y * frame.t - 2 * radius * direction, direction};
}

}  // namespace

Lights::Lights(const Scene& scene, const Bounds3& bounds) {
  center_ = bounds.empty() ? Vec3(0) : bounds.center();
  radius_ = bounds.radius();
  first_of_instance_.assign(scene.instances.size(), kNoLight);
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    if (!scene.materials[mesh.material].emissive()) continue;
    add_triangles(scene, i);
  }
  for (std::uint32_t i = 0; i < scene.lights.size(); ++i) {
    add({Light::Kind::punctual, 0, i}, punctual_power(scene.lights[i], radius_));
  }
  if (scene.environment.active()) {
    environment_ = static_cast<std::int64_t>(lights_.size());
    add({Light::Kind::environment, 0, 0}, 4.0 * kPi * kPi * radius_ * radius_ * scene.environment.mean());
  }
  total_power_ = std::accumulate(powers_.begin(), powers_.end(), 0.0);
  if (lights_.empty()) return;
  const double floor = kFloor / static_cast<double>(lights_.size());
  for (double& power : powers_) {
    power = total_power_ > 0 ? (1 - kFloor) * power / total_power_ + floor : floor;
  }
  choice_ = AliasTable(powers_);
  powers_ = {};
  for (std::size_t i = 0; i < emitters_.size(); ++i) {
    const float sides = scene.materials[emitters_[i].material].double_sided ? 2 : 1;
    emitters_[i].etendue = sides * kPi * emitters_[i].area / choice_.pdf(i);
  }
}

void Lights::add(const Light& light, double power) {
  lights_.push_back(light);
  powers_.push_back(power);
}

void Lights::add_triangles(const Scene& scene, std::uint32_t instance) {
  first_of_instance_[instance] = static_cast<std::uint32_t>(lights_.size());
  const std::size_t count = scene.meshes[scene.instances[instance].mesh].triangles.size();
  for (std::uint32_t t = 0; t < count; ++t) {
    emitters_.push_back(emitter_triangle(scene, instance, t));
    add({Light::Kind::triangle, instance, t}, 0);
    powers_.back() = triangle_power(scene, static_cast<std::uint32_t>(lights_.size() - 1));
  }
}

// A point of an emissive triangle, seen from its front, with what emitted_radiance needs.
SurfacePoint Lights::emitter_point(const Scene& scene, std::uint32_t index, const Vec2& uv) const {
  const EmitterTriangle& emitter = emitters_[index];
  SurfacePoint s;
  s.position = emitter.origin + uv.x * emitter.ab + uv.y * emitter.ac;
  s.ng = s.ns = emitter.normal;
  s.extent = emitter.extent;
  s.material = &scene.materials[emitter.material];
  if (s.material->emission_texture.used()) {
    const Light& light = lights_[index];
    const Instance& placed = scene.instances[light.instance];
    s.instance = light.instance;
    s.triangle = light.index;
    s.mesh = &scene.meshes[placed.mesh];
    const bool mirrored = placed.moved && is_mirrored(placed.to_world);
    s.vertices = s.mesh->triangles[light.index];
    s.u = mirrored ? uv.y : uv.x;
    s.v = mirrored ? uv.x : uv.y;
  }
  return s;
}

double Lights::triangle_power(const Scene& scene, std::uint32_t light) const {
  const Material& material = scene.materials[emitters_[light].material];
  const double sides = material.double_sided ? 2 : 1;
  double radiance = mean(material.emission);
  if (material.emission_texture.used()) {
    // A stratified look at the texture: a choice probability may be rough, and the floor covers what it misses.
    static constexpr int kSide = 4;
    radiance = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vec2 u{(static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide};
      const SurfacePoint s = emitter_point(scene, light, square_to_triangle(u));
      radiance += mean(emitted_radiance(scene, s)) / (kSide * kSide);
    }
  }
  return sides * kPi * emitters_[light].area * radiance;
}

DirectSample Lights::sample_triangle(const Scene& scene, std::uint32_t light, const Vec3& point, const Vec2& u) const {
  const float area = emitters_[light].area;
  SurfacePoint s = emitter_point(scene, light, square_to_triangle(u));
  const Vec3 to_light = s.position - point;
  const float distance_sq = glm::dot(to_light, to_light);
  if (!(distance_sq > 0) || !(area > 0)) return {};
  DirectSample sample;
  sample.wi = to_light / std::sqrt(distance_sq);
  float cos_l = -glm::dot(s.ng, sample.wi);
  if (cos_l < 0) {
    s.front = false;
    s.ng = -s.ng;
    cos_l = -cos_l;
  }
  if (cos_l == 0) return {};
  sample.pdf_w = choice_.pdf(light) * distance_sq / (cos_l * area);
  sample.radiance = emitted_radiance(scene, s) / sample.pdf_w;
  sample.etendue = emitters_[light].etendue;
  sample.target = spawn_point(s.position, s.ng, s.extent, -sample.wi);
  return sample;
}

EmissionSample Lights::emit_triangle(const Scene& scene, std::uint32_t light, Rng& rng) const {
  const Vec2 uv = square_to_triangle(rng.next2());
  const Vec3 local = square_to_cosine_hemisphere(rng.next2());
  SurfacePoint s = emitter_point(scene, light, uv);
  if (s.material->double_sided) {
    s.front = rng.next() < 0.5f;
    if (!s.front) s.ng = -s.ng;
  }
  return {spawn_ray(s, Frame(s.ng).to_world(local)), emitted_radiance(scene, s) * emitters_[light].etendue,
          emitters_[light].etendue};
}

EmittedFlux Lights::begin_emission(const Scene& scene, std::uint32_t light, Rng& rng, std::uint32_t k,
                                   EmissionLanes& lanes) const {
  if (light >= emitters_.size()) return {};
  const EmitterTriangle& emitter = emitters_[light];
  const Material& material = scene.materials[emitter.material];
  if (material.emission_texture.used()) return {};
  lanes.origin.set(k, emitter.origin);
  lanes.ab.set(k, emitter.ab);
  lanes.ac.set(k, emitter.ac);
  for (auto& random : lanes.random) random[k] = rng.next();
  const float side = material.double_sided && rng.next() >= 0.5f ? -1.0f : 1.0f;
  lanes.normal.set(k, side * emitter.normal);
  lanes.extent[k] = emitter.extent;
  return {material.emission * emitter.etendue, emitter.etendue};
}

void EmissionLanes::emit(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec2 uv = square_to_triangle({random[0][i], random[1][i]});
    const Vec3 local = square_to_cosine_hemisphere({random[2][i], random[3][i]});
    const Vec3 at = origin[i] + uv.x * ab[i] + uv.y * ac[i];
    position.set(i, spawn_point(at, normal[i], extent[i], normal[i]));
    direction.set(i, Frame(normal[i]).to_world(local));
  }
}

DirectSample Lights::sample_direct(const Scene& scene, const Vec3& point, const Vec3& u) const {
  const std::uint32_t index = choice_.sample(u.z);
  const Light& light = lights_[index];
  const float choice = choice_.pdf(index);
  if (light.kind == Light::Kind::triangle) return sample_triangle(scene, index, point, Vec2(u));
  if (light.kind == Light::Kind::punctual) return sample_punctual(scene.lights[light.index], point, choice);
  const EnvironmentSample environment = scene.environment.sample(Vec2(u));
  DirectSample sample;
  sample.wi = environment.wi;
  sample.pdf_w = choice * environment.pdf_w;
  sample.etendue = environment_etendue(sample.pdf_w);
  sample.radiance = environment.radiance / sample.pdf_w;
  sample.infinite = true;
  return sample;
}

float Lights::pdf_direct(const Vec3& point, const SurfacePoint& s) const {
  const std::uint32_t first = first_of_instance_[s.instance];
  if (first == kNoLight) return 0;
  const float area = emitters_[first + s.triangle].area;
  const Vec3 to_light = s.position - point;
  const float distance_sq = glm::dot(to_light, to_light);
  const float cos_l = std::abs(glm::dot(s.ng, to_light)) / std::sqrt(distance_sq);
  return cos_l > 0 ? choice_.pdf(first + s.triangle) * distance_sq / (cos_l * area) : 0;
}

float Lights::pdf_environment(const Scene& scene, const Vec3& direction) const {
  if (environment_ < 0) return 0;
  return choice_.pdf(static_cast<std::size_t>(environment_)) * scene.environment.pdf_w(direction);
}

float Lights::etendue(const SurfacePoint& s) const {
  const std::uint32_t first = first_of_instance_[s.instance];
  return first == kNoLight ? kInfinity : emitters_[first + s.triangle].etendue;
}

float Lights::environment_etendue(float pdf) const {
  return pdf > 0 ? kPi * radius_ * radius_ / pdf : kInfinity;   // through a disc as large as the scene
}

EmissionSample Lights::sample_emission(const Scene& scene, std::uint32_t index, Rng& rng) const {
  if (index < emitters_.size()) return emit_triangle(scene, index, rng);
  const Light& light = lights_[index];
  const float choice = choice_.pdf(index);
  if (light.kind == Light::Kind::environment) {
    const EnvironmentSample from = scene.environment.sample(rng.next2());
    const Ray ray = ray_from_infinity(center_, radius_, -from.wi, rng.next2());
    const float etendue = environment_etendue(choice * from.pdf_w);
    return {ray, from.radiance * etendue, etendue};
  }
  const PunctualLight& source = scene.lights[light.index];
  if (source.type == LightType::directional) {
    const Ray ray = ray_from_infinity(center_, radius_, source.direction, rng.next2());
    return {ray, source.intensity * (kPi * radius_ * radius_ / choice)};
  }
  if (source.type == LightType::point) {
    return {{source.position, square_to_sphere(rng.next2())}, source.intensity * (4 * kPi / choice)};
  }
  const Vec3 local = square_to_cone(rng.next2(), source.cos_outer);
  const float scale = spot_attenuation(source, local.z) / (square_to_cone_pdf(source.cos_outer) * choice);
  return {{source.position, Frame(source.direction).to_world(local)}, source.intensity * scale};
}

}  // namespace photond
