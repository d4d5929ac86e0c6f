// Paths that leave lights.
#include <algorithm>

#include "core/math/frame.h"
#include "core/math/warp.h"
#include "core/trace/lights.h"

namespace photond {

EmissionSample Lights::emit_triangle(const Scene& scene, std::uint32_t light, const Aim& aim, Rng& rng) const {
  const EmitterTriangle& emitter = emitters_[light];
  const EmissionDomain& domain = domain_of(scene, light);
  std::uint32_t drawn = Aim::kNone;
  EmissionStart start;
  const bool aims = aim.draw(rng);
  if (aims) {
    start.place = rng.next2();
  } else {
    start = domain.draw(rng);
  }
  const EmissionPattern::Place place = pattern_of(light).draw(start.place);
  const Vec2 uv = square_to_triangle(place.u);
  const Vec3 position = emitter.at(uv);
  Vec3 direction;
  if (aims) {
    drawn = aim.choose(rng.next());
    direction = aim.direction(position, drawn, rng.next2());
    start.back = !(glm::dot(direction, emitter.normal) > 0);
  }
  const Frame side(start.back ? -emitter.normal : emitter.normal);
  if (aims) {
    start.direction = disk_to_square(Vec2(side.to_local(direction)));
    if (!domain.contains(start)) return {{position, direction}};   // beside everything that is there
  } else {
    direction = side.to_world(square_to_cosine_hemisphere(start.direction));
  }
  const float etendue = triangle_etendue(light, position, direction, aim, drawn) / place.density;
  const Ray ray{spawn_point(position, emitter.normal, emitter.extent, direction), direction};
  return {ray, emitted(scene, light, uv, !start.back) * etendue, etendue};
}

bool Lights::begin_emission(const Scene& scene, std::uint32_t light, Rng& rng, std::uint32_t k,
                            EmissionLanes& lanes) const {
  if (light >= emitters_.size()) return false;
  const EmitterTriangle& emitter = emitters_[light];
  const Material& material = scene.materials[emitter.material];
  if (!material.shines_evenly()) return false;
  const Aim& aim = aim_of(light);
  EmissionStart start;
  lanes.drawn[k] = Aim::kNone;
  if (aim.draw(rng)) {
    start.place = rng.next2();
    lanes.drawn[k] = aim.choose(rng.next());
    start.direction = rng.next2();
    const Ball& ball = aim.ball(lanes.drawn[k]);
    lanes.center.set(k, ball.center);
    lanes.radius[k] = ball.radius;
  } else {
    start = domain_of(scene, light).draw(rng);
  }
  lanes.origin.set(k, emitter.origin);
  lanes.ab.set(k, emitter.ab);
  lanes.ac.set(k, emitter.ac);
  lanes.random[0][k] = start.place.x;
  lanes.random[1][k] = start.place.y;
  lanes.random[2][k] = start.direction.x;
  lanes.random[3][k] = start.direction.y;
  lanes.normal.set(k, start.back ? -emitter.normal : emitter.normal);
  lanes.extent[k] = emitter.extent;
  lanes.flux.set(k, material.emission * emitter.etendue);
  lanes.etendue[k] = emitter.etendue;
  return true;
}

void Lights::share_aimed(const Scene& scene, std::uint32_t light, std::uint32_t k, EmissionLanes& lanes) const {
  if (!(lanes.etendue[k] > 0)) return;   // of a triangle without area
  float etendue = 0;
  if (lanes.drawn[k] == Aim::kNone || domain_of(scene, light).contains(lanes.start(k))) {
    etendue = aimed_etendue(light, lanes.position[k], lanes.direction[k], aim_of(light), lanes.drawn[k]);
  }
  lanes.flux.set(k, lanes.flux[k] * (etendue / lanes.etendue[k]));
  lanes.etendue[k] = etendue;
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
  if (std::any_of(drawn, drawn + count, [](std::uint32_t ball) { return ball != Aim::kNone; })) aim(count);
}

// Replaces the rays of those that aim.
void EmissionLanes::aim(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const bool aims = drawn[i] != Aim::kNone;
    const Vec2 uv = square_to_triangle({random[0][i], random[1][i]});
    const Vec3 at = origin[i] + uv.x * ab[i] + uv.y * ac[i];
    const Vec3 towards = square_to_ball({random[2][i], random[3][i]}, center[i] - at, radius[i]);
    back[i] = !(glm::dot(towards, normal[i]) > 0);
    const Vec2 left = disk_to_square(Vec2(Frame(choose(back[i], -normal[i], normal[i])).to_local(towards)));
    random[2][i] = choose(aims, left.x, random[2][i]);
    random[3][i] = choose(aims, left.y, random[3][i]);
    position.set(i, choose(aims, spawn_point(at, normal[i], extent[i], towards), position[i]));
    direction.set(i, choose(aims, towards, direction[i]));
  }
}

// A ray along `direction` that starts outside of the scene, and its `line_pdf`.
Ray Lights::ray_from_infinity(const Vec3& direction, const Aim& aim, Rng& rng, float& pdf_a) const {
  Vec3 place;
  std::uint32_t drawn = Aim::kNone;
  if (aim.draw(rng)) {
    drawn = aim.choose(rng.next());
    place = aim.place(direction, drawn, rng.next2());
    place -= glm::dot(place - bounds_.center(), direction) * direction;
  } else {
    const Vec2 u = rng.next2();
    place = bounds_.sample(direction, {u, rng.next()});
  }
  pdf_a = line_pdf(place, direction, aim, drawn);
  // Twice the radius away: outside the sphere whatever rounding does.
  return {place - 2 * ball_.radius * direction, direction};
}

EmissionSample Lights::emit_point(const PunctualLight& light, float choice, float sent, const Aim& aim, Rng& rng) const {
  const bool spot = light.type == LightType::spot;
  const bool towards = sent < 1;   // the scene's bounds
  const Vec3 to_center = ball_.center - light.position;
  const float ordinary = towards ? square_to_cone_pdf(cap_height(to_center, ball_.radius))
                         : spot  ? square_to_cone_pdf(light.outer_height())
                                 : kSpherePdf;
  std::uint32_t drawn = Aim::kNone;
  Vec3 direction;
  if (aim.draw(rng)) {
    drawn = aim.choose(rng.next());
    direction = aim.direction(light.position, drawn, rng.next2());
  } else if (towards) {
    direction = square_to_ball(rng.next2(), to_center, ball_.radius);
  } else if (spot) {
    direction = Frame(light.direction).to_world(square_to_cone(rng.next2(), light.outer_height()));
  } else {
    direction = square_to_sphere(rng.next2());
  }
  const bool astray = drawn != Aim::kNone && towards && !meets(ball_, light.position, direction);
  if (astray) return {{light.position, direction}};
  float pdf_w = ordinary;
  if (aim.share() > 0) {
    pdf_w = (1 - aim.share()) * ordinary + aim.share() * aim.pdf_w(light.position, direction, drawn);
  }
  const Vec3 origin = light.position + clearance(light.position) * direction;
  return {{origin, direction}, light.intensity * (light.attenuation(direction) / (pdf_w * choice))};
}

EmissionSample Lights::sample_emission(const Scene& scene, std::uint32_t index, const Aim& aim, Rng& rng) const {
  if (index < emitters_.size()) return emit_triangle(scene, index, aim, rng);
  const Light& light = lights_[index];
  const float choice = emission_choice_.pdf(index);
  float pdf_a = 0;
  if (light.kind == Light::Kind::environment) {
    const EnvironmentSample from = scene.environment.sample(rng.next2());
    const Ray ray = ray_from_infinity(-from.wi, aim, rng, pdf_a);
    const float etendue = 1 / (choice * from.pdf_w * pdf_a);
    return {ray, from.radiance * etendue, environment_casts_ ? etendue : kInfinity};
  }
  const PunctualLight& source = scene.lights[light.index];
  if (source.type != LightType::directional) return emit_point(source, choice, sent_[index], aim, rng);
  const Ray ray = ray_from_infinity(source.direction, aim, rng, pdf_a);
  return {ray, source.intensity / (pdf_a * choice)};
}

}  // namespace photond
