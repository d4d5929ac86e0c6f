// Veach 1997: next-event estimation and multiple importance sampling.
#include "core/render/plain_vertices.h"

#include "core/math/frame.h"
#include "core/math/warp.h"

namespace photond {

void PlainVertices::shade(const PreparedScene& scene, std::uint32_t count) {
  samplers.next2(count, direct_.random[0], direct_.random[1]);
  samplers.next2(count, choice_, roulette_);
  samplers.next2(count, random_[0], random_[1]);
  find_points(count);
  sample_lights(scene, count);
  light_points(count);
  scatter(count);
}

void PlainVertices::find_points(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const FlatPoint p = at.point(i, direction[i]);
    position_.set(i, p.position);
    ng_.set(i, p.ng);
    extent_[i] = p.extent;
  }
}

void PlainVertices::sample_lights(const PreparedScene& scene, std::uint32_t count) {
  direct_.point = position_;
  std::uint32_t others[kLanes];
  const std::uint32_t other_count = scene.lights.begin_direct(scene.scene, count, choice_, direct_, others);
  direct_.sample(count);
  for (std::uint32_t i = 0; i < other_count; ++i) {
    const std::uint32_t k = others[i];
    const Vec3 random{direct_.random[0][k], direct_.random[1][k], choice_[k]};
    direct_.set(k, scene.lights.sample_direct(scene.scene, position_[k], random));
  }
}

void PlainVertices::light_points(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec3 wi = direct_.wi[i];
    const float pdf = std::max(glm::dot(wi, ng_[i]), 0.0f) * kInvPi;   // of going on that way
    const float pdf_direct = direct_.pdf_w[i];
    const float weight = choose(pdf_direct > 0, power_heuristic(pdf_direct, pdf), 1);
    light.set(i, throughput[i] * albedo[i] * direct_.radiance[i] * (pdf * weight));
    const Vec3 from = spawn_point(position_[i], ng_[i], extent_[i], ng_[i]);
    const bool infinite = direct_.infinite[i] != 0;
    const Vec3 to_target = direct_.target[i] - from;
    shadow.origin.set(i, from);
    shadow.direction.set(i, {choose(infinite, wi.x, to_target.x), choose(infinite, wi.y, to_target.y),
                             choose(infinite, wi.z, to_target.z)});
    shadow.t_max[i] = choose(infinite, kInfinity, 1);
  }
}

void PlainVertices::scatter(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec3 local = square_to_cosine_hemisphere({random_[0][i], random_[1][i]});
    const Rgb reflected = throughput[i] * albedo[i];
    const float survival = roulette_survival(reflected, compression[i], depth[i]);
    const bool survives = roulette_[i] < (local.z > 0 ? survival : 0);
    origin.set(i, spawn_point(position_[i], ng_[i], extent_[i], ng_[i]));
    next_direction.set(i, Frame(ng_[i]).to_world(local));
    next_throughput.set(i, reflected * choose(survives, 1 / survival, 0));
    next_pdf[i] = local.z * kInvPi;
  }
}

}  // namespace photond
