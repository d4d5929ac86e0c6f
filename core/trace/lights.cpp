#include "core/trace/lights.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "core/math/transform.h"
#include "core/math/warp.h"
#include "core/trace/casters.h"
#include "core/trace/coverage.h"

namespace photond {

namespace {

// Share of the choices that ignores power: a light of no estimated power still gets its turn.
constexpr double kFloor = 0.05;

double mean(const Rgb& c) { return (static_cast<double>(c.x) + c.y + c.z) / 3; }

EmitterTriangle emitter_triangle(const Scene& scene, std::uint32_t instance, std::uint32_t triangle) {
  const TriangleVertices world = triangle_vertices(scene, instance, triangle);
  EmitterTriangle emitter{world.a, world.b - world.a, world.c - world.a, {0, 0, 1}, 0, 0, 0, 0};
  // In double: the squares of the areas of the largest triangles and of the smallest are no floats.
  const glm::dvec3 normal = glm::cross(glm::dvec3(emitter.ab), glm::dvec3(emitter.ac));
  const double length = glm::length(normal);
  if (length > 0) emitter.normal = Vec3(normal / length);
  emitter.area = static_cast<float>(0.5 * length);
  emitter.extent = world.extent();
  emitter.material = scene.meshes[scene.instances[instance].mesh].material;
  return emitter;
}

// The power of a spot of intensity 1.
double cone_power(const PunctualLight& spot) {
  return 2 * kPi * ((1 - spot.cos_inner) + (spot.cos_inner - spot.cos_outer) / 3);
}

// Share of a spot's power that goes towards the ball, where that fills less than its cone; else 1.
float share_towards(const PunctualLight& spot, const Ball& ball) {
  const Vec3 to_center = ball.center - spot.position;
  const float height = cap_height(to_center, ball.radius);
  if (!(height < spot.outer_height())) return 1;
  static constexpr int kSide = 16;
  double sum = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 u{(static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide};
    sum += static_cast<double>(spot.attenuation(square_to_ball(u, to_center, ball.radius))) / (kSide * kSide);
  }
  const auto share = static_cast<float>(2 * kPi * static_cast<double>(height) * sum / cone_power(spot));
  return share > 0 ? std::min(share, 1.0f) : 1;
}

double punctual_power(const PunctualLight& light, const BoxLines& bounds) {
  const double intensity = mean(light.intensity);
  switch (light.type) {
    case LightType::point:
      return 4 * kPi * intensity;
    case LightType::spot:
      return intensity * cone_power(light);
    case LightType::directional:
      return bounds.area(light.direction) * intensity;
  }
  return 0;
}

}  // namespace

Lights::Lights(const Scene& scene, const Bounds3& bounds) {
  bounds_ = BoxLines(bounds);
  ball_ = {bounds_.center(), 1.0001f * bounds.radius()};   // so that no direction is lost by rounding
  first_of_instance_.assign(scene.instances.size(), kNoLight);
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    if (!scene.materials[mesh.material].emissive()) continue;
    add_triangles(scene, i);
  }
  measure_uneven(scene);
  for (std::uint32_t i = 0; i < scene.lights.size(); ++i) {
    const PunctualLight& light = scene.lights[i];
    const float sent = light.type == LightType::point  ? share_towards_bounds(light.position)
                       : light.type == LightType::spot ? share_towards(light, ball_)
                                                       : 1;
    add({Light::Kind::punctual, 0, i}, punctual_power(light, bounds_), sent);
  }
  if (scene.environment.active()) {
    environment_ = static_cast<std::int64_t>(lights_.size());
    environment_casts_ = photond::environment_casts(scene);
    add({Light::Kind::environment, 0, 0}, 4.0 * kPi * bounds_.mean_area() * scene.environment.mean());
  }
  if (lights_.empty()) return;
  const double sum = std::accumulate(powers_.begin(), powers_.end(), 0.0);
  const double floor = kFloor / static_cast<double>(lights_.size());
  for (double& power : powers_) power = sum > 0 ? (1 - kFloor) * power / sum + floor : floor;
  constexpr int kFar = 40;   // 2^±40 W
  const int exponent = total_power_ > 0 ? std::ilogb(total_power_) : 0;
  if (std::abs(exponent) > kFar) flux_unit_ = std::ldexp(1.0f, std::clamp(exponent, -126, 126));
  choice_ = AliasTable(powers_);
  set_emission_choice(powers_);
  powers_ = {};
  set_etendues(scene);
}

void Lights::set_etendues(const Scene& scene) {
  for (std::uint32_t i = 0; i < emitters_.size(); ++i) {
    EmitterTriangle& emitter = emitters_[i];
    const float sides = scene.materials[emitter.material].double_sided ? 2 : 1;
    emitter.etendue = sides * kPi * emitter.area * domain_of(scene, i).share() / emission_choice_.pdf(i);
  }
}

void Lights::set_domains(const Scene& scene, std::vector<EmissionDomain> domains) {
  domains_ = std::move(domains);
  std::vector<double> chances(lights_.size());
  for (std::uint32_t i = 0; i < lights_.size(); ++i) chances[i] = static_cast<double>(choice_.pdf(i));
  for (std::uint32_t i = 0; i < domains_.size(); ++i) {
    sent_[i] = domains_[i].share();
    chances[i] *= static_cast<double>(sent_[i]);
  }
  set_emission_choice(chances);
  set_etendues(scene);
}

void Lights::set_emission_choice(std::span<const double> chances) {
  emission_choice_ = AliasTable(chances);
  casting_share_ = 1;
  if (!leaves_out()) return;
  std::vector<double> casting(chances.size());
  for (std::uint32_t i = 0; i < casting.size(); ++i) {
    if (i != environment_) casting[i] = static_cast<double>(emission_choice_.pdf(i));
  }
  casting_share_ = std::accumulate(casting.begin(), casting.end(), 0.0);
  if (casting_share_ > 0) casting_choice_ = AliasTable(casting);
}

void Lights::add(const Light& light, double power, float sent) {
  lights_.push_back(light);
  sent_.push_back(sent);
  powers_.push_back(power * static_cast<double>(sent));
  total_power_ += power;
}

// Share of all directions from a point that a path may take to meet the scene's bounding sphere.
float Lights::share_towards_bounds(const Vec3& point) const {
  const float share = 0.5f * cap_height(ball_.center - point, ball_.radius);
  constexpr float kLeast = 1e-30f;   // the inverse of what is less may be too large for a float
  return share > kLeast ? share : 1;
}

void Lights::add_triangles(const Scene& scene, std::uint32_t instance) {
  first_of_instance_[instance] = static_cast<std::uint32_t>(lights_.size());
  const std::size_t count = scene.meshes[scene.instances[instance].mesh].triangles.size();
  for (std::uint32_t t = 0; t < count; ++t) {
    emitters_.push_back(emitter_triangle(scene, instance, t));
    add({Light::Kind::triangle, instance, t}, 0);
    const auto light = static_cast<std::uint32_t>(lights_.size() - 1);
    const Material& material = scene.materials[emitters_[light].material];
    if (!material.shines_evenly()) continue;   // measured later
    powers_[light] = mean(material.emission) * power_per_radiance(scene, light);
    total_power_ += powers_[light];
  }
}

Vec2 Lights::on_mesh(const Scene& scene, std::uint32_t light, const Vec2& uv) const {
  const Instance& placed = scene.instances[lights_[light].instance];
  return placed.moved && is_mirrored(placed.to_world) ? Vec2(uv.y, uv.x) : uv;
}

[[gnu::noinline, gnu::cold]] Rgb Lights::emission_share(const Scene& scene, std::uint32_t index, const Vec2& uv) const {
  const Light& light = lights_[index];
  const Vec2 at = on_mesh(scene, index, uv);
  SurfacePoint s{};
  s.mesh = &scene.meshes[scene.instances[light.instance].mesh];
  s.vertices = s.mesh->triangles[light.index];
  s.u = at.x;
  s.v = at.y;
  const TextureSlot& texture = scene.materials[emitters_[index].material].emission_texture;
  return (texture.used() ? Rgb(lookup(scene, texture, s)) : Rgb(1)) * coverage(scene, *s.mesh, light.index, s.u, s.v);
}

double Lights::power_per_radiance(const Scene& scene, std::uint32_t light) const {
  const double sides = scene.materials[emitters_[light].material].double_sided ? 2 : 1;
  return sides * kPi * emitters_[light].area;
}

[[gnu::noinline]] float Lights::place_density(const Scene& scene, std::uint32_t light, const SurfacePoint& s) const {
  const EmissionPattern& pattern = pattern_of(light);
  return pattern.even() ? 1 : pattern.density(triangle_to_square(on_mesh(scene, light, {s.u, s.v})));
}

// The densities of directions compared: that of ordinary emission, |cos θ|/π of a side's, and what it is with the aim.
[[gnu::noinline]] float Lights::aimed_etendue(std::uint32_t light, const Vec3& point, const Vec3& direction,
                                              const Aim& aim, std::uint32_t drawn) const {
  const EmitterTriangle& emitter = emitters_[light];
  if (!(emitter.etendue > 0)) return 0;
  const float cosine = std::abs(glm::dot(emitter.normal, direction));
  const float ordinary = cosine * emitter.area / (emission_choice_.pdf(light) * emitter.etendue);
  const float pdf_w = (1 - aim.share()) * ordinary + aim.share() * aim.pdf_w(point, direction, drawn);
  return emitter.etendue * (pdf_w > 0 ? ordinary / pdf_w : 1 / (1 - aim.share()));
}

float Lights::etendue(const Scene& scene, const SurfacePoint& s, const Vec3& direction) const {
  const std::uint32_t first = first_of_instance_[s.instance];
  if (first == kNoLight) return kInfinity;
  const std::uint32_t light = first + s.triangle;
  return triangle_etendue(light, s.position, direction, aim_of(light), Aim::kNone) / place_density(scene, light, s);
}

float Lights::environment_etendue(float pdf, const Vec3& point, const Vec3& from) const {
  if (!(pdf > 0) || !environment_casts_) return kInfinity;
  const auto light = static_cast<std::uint32_t>(environment_);
  const float emitted = pdf * (emission_choice_.pdf(light) / choice_.pdf(light));
  return 1 / (emitted * line_pdf(point, from, aim_of(light), Aim::kNone));
}

// Density, per area across them, of the lines along `direction` that are emitted: through the scene's bounds, or aimed.
// Not zero for lines that meet the scene.
float Lights::line_pdf(const Vec3& point, const Vec3& direction, const Aim& aim, std::uint32_t drawn) const {
  const float ordinary = 1 / bounds_.area(direction);
  if (aim.share() == 0) return ordinary;
  const bool outside = drawn != Aim::kNone && !bounds_.meets(point, direction);
  return (outside ? 0 : (1 - aim.share()) * ordinary) + aim.share() * aim.pdf_a(point, direction, drawn);
}

std::vector<LightGroup> Lights::groups() const {
  std::vector<LightGroup> groups;
  for (std::uint32_t i = 0; i < lights_.size(); ++i) {
    const bool same = i < emitters_.size() && !groups.empty() && lights_[i].instance == lights_[groups.back().first].instance;
    if (same) {
      ++groups.back().count;
    } else {
      groups.push_back({i, 1});
    }
  }
  return groups;
}

std::optional<Vec3> Lights::place(const Scene& scene, std::uint32_t light) const {
  if (light < emitters_.size()) {
    const EmitterTriangle& emitter = emitters_[light];
    return spawn_point(emitter.at(Vec2(1.0f / 3)), emitter.normal, emitter.extent, emitter.normal);
  }
  const bool far = lights_[light].kind == Light::Kind::environment ||
                   scene.lights[lights_[light].index].type == LightType::directional;
  return far ? std::nullopt : std::optional(scene.lights[lights_[light].index].position);
}

std::uint64_t Lights::memory_bytes() const {
  std::uint64_t bytes = choice_.memory_bytes() + emission_choice_.memory_bytes() + casting_choice_.memory_bytes();
  for (const EmissionPattern& pattern : patterns_) bytes += sizeof(pattern) + pattern.memory_bytes();
  return bytes + lights_.size() * (sizeof(Light) + sizeof(float)) + emitters_.size() * sizeof(EmitterTriangle) +
         (pattern_of_.size() + aim_of_.size() + first_of_instance_.size()) * sizeof(std::uint32_t) +
         powers_.capacity() * sizeof(double);
}

void Lights::set_aim(const LightGroup& group, Aim aim) {
  aim_of_.resize(lights_.size(), 0);
  std::fill_n(aim_of_.begin() + group.first, group.count, static_cast<std::uint32_t>(aims_.size()));
  aims_.push_back(std::move(aim));
}

}  // namespace photond
