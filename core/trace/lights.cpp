#include "core/trace/lights.h"

#include <cmath>
#include <numeric>

#include "core/math/frame.h"
#include "core/math/transform.h"
#include "core/math/warp.h"
#include "core/trace/casters.h"

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
    environment_casts_ = photond::environment_casts(scene);
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

// What the emission texture says of a point of an emissive triangle.
[[gnu::noinline, gnu::cold]] Rgb Lights::emission_texel(const Scene& scene, std::uint32_t index, const Vec2& uv) const {
  const Light& light = lights_[index];
  const Instance& placed = scene.instances[light.instance];
  const bool mirrored = placed.moved && is_mirrored(placed.to_world);
  SurfacePoint s{};
  s.mesh = &scene.meshes[placed.mesh];
  s.vertices = s.mesh->triangles[light.index];
  s.u = mirrored ? uv.y : uv.x;
  s.v = mirrored ? uv.x : uv.y;
  return Rgb(lookup(scene, scene.materials[emitters_[index].material].emission_texture, s));
}

// Radiance that leaves it on its front or its back.
[[gnu::always_inline]] inline Rgb Lights::emitted(const Scene& scene, std::uint32_t index, const Vec2& uv, bool front) const {
  const Material& material = scene.materials[emitters_[index].material];
  if (!front && !material.double_sided) return Rgb(0);
  if (!material.emission_texture.used()) return material.emission;
  return material.emission * emission_texel(scene, index, uv);
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
      radiance += mean(emitted(scene, light, square_to_triangle(u), true)) / (kSide * kSide);
    }
  }
  return sides * kPi * emitters_[light].area * radiance;
}

// From the density of ordinary emission, |cos θ|/π of a side's, and of the aim.
[[gnu::noinline]] float Lights::aimed_etendue(std::uint32_t light, const Vec3& point, const Vec3& direction,
                                              const Aim& aim, std::uint32_t drawn) const {
  const EmitterTriangle& emitter = emitters_[light];
  const float projected = std::abs(glm::dot(emitter.normal, direction)) * emitter.area / choice_.pdf(light);
  const float ordinary = projected / emitter.etendue;
  const float pdf_w = (1 - aim.share()) * ordinary + aim.share() * aim.pdf_w(point, direction, drawn);
  return pdf_w > 0 ? projected / pdf_w : kInfinity;
}

[[gnu::always_inline]] inline float Lights::triangle_etendue(std::uint32_t light, const Vec3& point, const Vec3& direction,
                                                             const Aim& aim, std::uint32_t drawn) const {
  return aim.share() == 0 ? emitters_[light].etendue : aimed_etendue(light, point, direction, aim, drawn);
}

DirectSample Lights::sample_triangle(const Scene& scene, std::uint32_t light, const Vec3& point, const Vec2& u) const {
  const EmitterTriangle& emitter = emitters_[light];
  const Vec2 uv = square_to_triangle(u);
  const Vec3 position = emitter.at(uv);
  const Vec3 to_light = position - point;
  const float distance_sq = glm::dot(to_light, to_light);
  if (!(distance_sq > 0) || !(emitter.area > 0)) return {};
  DirectSample sample;
  sample.wi = to_light / std::sqrt(distance_sq);
  const float cosine = -glm::dot(emitter.normal, sample.wi);
  if (cosine == 0) return {};
  sample.pdf_w = choice_.pdf(light) * distance_sq / (std::abs(cosine) * emitter.area);
  sample.target = spawn_point(position, emitter.normal, emitter.extent, -sample.wi);
  // These last: a call would spill what they do not need.
  sample.radiance = emitted(scene, light, uv, cosine > 0) / sample.pdf_w;
  sample.etendue = triangle_etendue(light, position, -sample.wi, aim_of(light), Aim::kNone);
  return sample;
}

EmissionSample Lights::emit_triangle(const Scene& scene, std::uint32_t light, const Aim& aim, Rng& rng) const {
  const EmitterTriangle& emitter = emitters_[light];
  const Vec2 uv = square_to_triangle(rng.next2());
  const Vec3 position = emitter.at(uv);
  std::uint32_t drawn = Aim::kNone;
  Vec3 direction;
  bool front = true;
  if (aim.share() > 0 && rng.next() < aim.share()) {
    drawn = aim.choose(rng.next());
    direction = aim.direction(position, drawn, rng.next2());
    front = glm::dot(direction, emitter.normal) > 0;
  } else {
    const Vec3 local = square_to_cosine_hemisphere(rng.next2());
    if (scene.materials[emitter.material].double_sided) front = rng.next() < 0.5f;
    direction = Frame(front ? emitter.normal : -emitter.normal).to_world(local);
  }
  const float etendue = triangle_etendue(light, position, direction, aim, drawn);
  const Ray ray{spawn_point(position, emitter.normal, emitter.extent, direction), direction};
  return {ray, emitted(scene, light, uv, front) * etendue, etendue};
}

EmittedFlux Lights::begin_emission(const Scene& scene, std::uint32_t light, Rng& rng, std::uint32_t k,
                                   EmissionLanes& lanes) const {
  if (light >= emitters_.size()) return {};
  const EmitterTriangle& emitter = emitters_[light];
  const Material& material = scene.materials[emitter.material];
  if (material.emission_texture.used() || aim_of(light).share() > 0) return {};
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
  sample.etendue = environment_etendue(sample.pdf_w, point, sample.wi);
  sample.radiance = environment.radiance / sample.pdf_w;
  sample.infinite = true;
  return sample;
}

std::uint32_t Lights::begin_direct(const Scene& scene, std::span<const std::uint32_t> which, const float (&u)[kLanes],
                                   DirectLanes& lanes, std::uint32_t (&others)[kLanes]) const {
  std::uint32_t other_count = 0;
  for (const std::uint32_t k : which) {
    const std::uint32_t light = choice_.sample(u[k]);
    const EmitterTriangle* emitter = light < emitters_.size() ? &emitters_[light] : nullptr;
    const Material* material = emitter != nullptr ? &scene.materials[emitter->material] : nullptr;
    if (material == nullptr || material->emission_texture.used()) {
      others[other_count++] = k;
      continue;
    }
    lanes.origin.set(k, emitter->origin);
    lanes.ab.set(k, emitter->ab);
    lanes.ac.set(k, emitter->ac);
    lanes.normal.set(k, emitter->normal);
    lanes.emission.set(k, material->emission);
    lanes.area[k] = emitter->area;
    lanes.probability[k] = choice_.pdf(light);
    lanes.extent[k] = emitter->extent;
    lanes.back[k] = material->double_sided ? 1 : 0;
  }
  return other_count;
}

void DirectLanes::sample(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec2 uv = square_to_triangle({random[0][i], random[1][i]});
    const Vec3 at = origin[i] + uv.x * ab[i] + uv.y * ac[i];
    const Vec3 to_light = at - point[i];
    const float distance_sq = glm::dot(to_light, to_light);
    const Vec3 direction = to_light * (1 / std::sqrt(distance_sq));
    const float cosine = -glm::dot(normal[i], direction);
    const float facing = std::abs(cosine) * (area[i] / probability[i]);
    const float shines = choose(cosine > 0, 1, back[i]);
    // Where the light is seen edge-on, or from itself, there is none.
    const bool seen = (distance_sq > 0) & (facing > 0);
    wi.set(i, direction);
    radiance.set(i, emission[i] * choose(seen, shines * facing / distance_sq, 0));
    pdf_w[i] = choose(seen, distance_sq / facing, 0);
    target.set(i, spawn_point(at, normal[i], extent[i], -direction));
    infinite[i] = 0;
  }
}

float Lights::pdf_direct(const SurfacePoint& s, const Vec3& direction, float distance) const {
  const std::uint32_t first = first_of_instance_[s.instance];
  if (first == kNoLight) return 0;
  const float area = emitters_[first + s.triangle].area;
  const float cos_l = std::abs(glm::dot(s.ng, direction));
  return cos_l > 0 ? choice_.pdf(first + s.triangle) * distance * distance / (cos_l * area) : 0;
}

float Lights::pdf_environment(const Scene& scene, const Vec3& direction) const {
  if (environment_ < 0) return 0;
  return choice_.pdf(static_cast<std::size_t>(environment_)) * scene.environment.pdf_w(direction);
}

float Lights::etendue(const SurfacePoint& s, const Vec3& direction) const {
  const std::uint32_t first = first_of_instance_[s.instance];
  if (first == kNoLight) return kInfinity;
  const std::uint32_t light = first + s.triangle;
  return triangle_etendue(light, s.position, direction, aim_of(light), Aim::kNone);
}

float Lights::environment_etendue(float pdf, const Vec3& point, const Vec3& from) const {
  if (!(pdf > 0) || !environment_casts_) return kInfinity;
  const Aim& aim = aim_of(static_cast<std::uint32_t>(environment_));
  return 1 / (pdf * line_pdf(point, from, aim, Aim::kNone));
}

// Density, per area across them, of the lines along `direction` that are emitted: through the disc that the scene's
// bounding sphere fills, or aimed. Not zero for lines that meet the scene.
float Lights::line_pdf(const Vec3& point, const Vec3& direction, const Aim& aim, std::uint32_t drawn) const {
  const float radius_sq = radius_ * radius_;
  const float ordinary = kInvPi / radius_sq;
  if (aim.share() == 0) return ordinary;
  const Vec3 beside = glm::cross(point - center_, direction);
  const bool outside = drawn != Aim::kNone && glm::dot(beside, beside) > radius_sq;
  return (outside ? 0 : (1 - aim.share()) * ordinary) + aim.share() * aim.pdf_a(point, direction, drawn);
}

// A ray along `direction` that starts outside of the scene, and its `line_pdf`.
Ray Lights::ray_from_infinity(const Vec3& direction, const Aim& aim, Rng& rng, float& pdf_a) const {
  Vec3 place;
  std::uint32_t drawn = Aim::kNone;
  if (aim.share() > 0 && rng.next() < aim.share()) {
    drawn = aim.choose(rng.next());
    place = aim.place(direction, drawn, rng.next2());
    place -= glm::dot(place - center_, direction) * direction;
  } else {
    const Frame frame(direction);
    const Vec2 d = square_to_disk(rng.next2()) * radius_;
    place = center_ + d.x * frame.s + d.y * frame.t;
  }
  pdf_a = line_pdf(place, direction, aim, drawn);
  // Twice the radius away: outside the sphere whatever rounding does.
  return {place - 2 * radius_ * direction, direction};
}

EmissionSample Lights::emit_point(const PunctualLight& light, float choice, const Aim& aim, Rng& rng) const {
  const bool spot = light.type == LightType::spot;
  const float cone_pdf = spot ? square_to_cone_pdf(light.cos_outer) : kSpherePdf;
  std::uint32_t drawn = Aim::kNone;
  Vec3 direction;
  if (aim.share() > 0 && rng.next() < aim.share()) {
    drawn = aim.choose(rng.next());
    direction = aim.direction(light.position, drawn, rng.next2());
  } else if (spot) {
    direction = Frame(light.direction).to_world(square_to_cone(rng.next2(), light.cos_outer));
  } else {
    direction = square_to_sphere(rng.next2());
  }
  const float cosine = glm::dot(direction, light.direction);
  if (spot && drawn != Aim::kNone && cosine < light.cos_outer) return {{light.position, direction}};
  float pdf_w = cone_pdf;
  if (aim.share() > 0) {
    pdf_w = (1 - aim.share()) * cone_pdf + aim.share() * aim.pdf_w(light.position, direction, drawn);
  }
  return {{light.position, direction}, light.intensity * (spot_attenuation(light, cosine) / (pdf_w * choice))};
}

EmissionSample Lights::sample_emission(const Scene& scene, std::uint32_t index, const Aim& aim, Rng& rng) const {
  if (index < emitters_.size()) return emit_triangle(scene, index, aim, rng);
  const Light& light = lights_[index];
  const float choice = choice_.pdf(index);
  float pdf_a = 0;
  if (light.kind == Light::Kind::environment) {
    const EnvironmentSample from = scene.environment.sample(rng.next2());
    const Ray ray = ray_from_infinity(-from.wi, aim, rng, pdf_a);
    const float etendue = 1 / (choice * from.pdf_w * pdf_a);
    return {ray, from.radiance * etendue, environment_casts_ ? etendue : kInfinity};
  }
  const PunctualLight& source = scene.lights[light.index];
  if (source.type != LightType::directional) return emit_point(source, choice, aim, rng);
  const Ray ray = ray_from_infinity(source.direction, aim, rng, pdf_a);
  return {ray, source.intensity / (pdf_a * choice)};
}

std::uint32_t Lights::choose_casting(Rng& rng) const {
  std::uint32_t light = choose(rng.next());
  while (light == environment_ && !environment_casts_) light = choose(rng.next());
  return light;
}

double Lights::casting_share() const {
  if (lights_.empty()) return 0;
  const bool left_out = environment_ >= 0 && !environment_casts_;
  if (left_out && lights_.size() == 1) return 0;
  return left_out ? 1 - static_cast<double>(choice_.pdf(static_cast<std::size_t>(environment_))) : 1;
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

void Lights::set_aim(const LightGroup& group, Aim aim) {
  aim_of_.resize(lights_.size(), 0);
  std::fill_n(aim_of_.begin() + group.first, group.count, static_cast<std::uint32_t>(aims_.size()));
  aims_.push_back(std::move(aim));
}

}  // namespace photond
