// Light that is sampled from where it arrives.
#include <algorithm>
#include <cmath>

#include "core/math/warp.h"
#include "core/trace/lights.h"

namespace photond {

namespace {

DirectSample sample_punctual(const PunctualLight& light, float clearance, const Vec3& point, float choice) {
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
  const float distance = std::sqrt(distance_sq);
  sample.wi = to_light / distance;
  const float attenuation = light.attenuation(-sample.wi);
  sample.radiance = light.intensity * (attenuation / (distance_sq * choice));
  sample.target = light.position - std::min(clearance, 0.5f * distance) * sample.wi;
  return sample;
}

}  // namespace

DirectSample Lights::sample_triangle(const Scene& scene, std::uint32_t light, const Vec3& point, const Vec2& u) const {
  const EmitterTriangle& emitter = emitters_[light];
  const EmissionPattern::Place place = pattern_of(light).draw(u);
  const Vec2 uv = square_to_triangle(place.u);
  const Vec3 position = emitter.at(uv);
  const Vec3 to_light = position - point;
  const float distance_sq = glm::dot(to_light, to_light);
  if (!(distance_sq > 0) || !(emitter.area > 0)) return {};
  DirectSample sample;
  sample.wi = to_light / std::sqrt(distance_sq);
  const float cosine = -glm::dot(emitter.normal, sample.wi);
  if (cosine == 0) return {};
  sample.pdf_w = choice_.pdf(light) * place.density * distance_sq / (std::abs(cosine) * emitter.area);
  sample.target = spawn_point(position, emitter.normal, emitter.extent, -sample.wi);
  // These last: a call would spill what they do not need.
  sample.radiance = emitted(scene, light, uv, cosine > 0) / sample.pdf_w;
  sample.etendue = triangle_etendue(light, position, -sample.wi, aim_of(light), Aim::kNone) / place.density;
  return sample;
}

DirectSample Lights::sample_direct(const Scene& scene, const Vec3& point, const Vec3& u) const {
  const std::uint32_t index = choice_.sample(u.z);
  const Light& light = lights_[index];
  const float choice = choice_.pdf(index);
  if (light.kind == Light::Kind::triangle) return sample_triangle(scene, index, point, Vec2(u));
  if (light.kind == Light::Kind::punctual) {
    const PunctualLight& source = scene.lights[light.index];
    return sample_punctual(source, clearance(source.position), point, choice);
  }
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
    if (material == nullptr || !material->shines_evenly()) {
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

float Lights::pdf_direct(const Scene& scene, const SurfacePoint& s, const Vec3& direction, float distance) const {
  const std::uint32_t first = first_of_instance_[s.instance];
  if (first == kNoLight) return 0;
  const std::uint32_t light = first + s.triangle;
  const float cos_l = std::abs(glm::dot(s.ng, direction));
  if (!(cos_l > 0)) return 0;
  return choice_.pdf(light) * place_density(scene, light, s) * distance * distance / (cos_l * emitters_[light].area);
}

float Lights::pdf_environment(const Scene& scene, const Vec3& direction) const {
  if (environment_ < 0) return 0;
  return choice_.pdf(static_cast<std::size_t>(environment_)) * scene.environment.pdf_w(direction);
}

}  // namespace photond
