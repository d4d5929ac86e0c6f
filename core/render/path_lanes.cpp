// Veach 1997: next-event estimation and multiple importance sampling.
#include "core/render/path_lanes.h"

#include "core/math/frame.h"
#include "core/math/warp.h"
#include "core/trace/specular.h"

namespace photond {

void PathLanes::begin(std::uint32_t k, const Ray& camera_ray, const CameraSampler& sampler, std::uint32_t index,
                      const Medium& start) {
  ray.set(k, camera_ray);
  throughput.set(k, Rgb(1));
  compression[k] = 1;
  last_pdf[k] = 0;
  depth[k] = 0;
  samplers.set(k, sampler);
  sample[k] = index;
  medium[k] = start;
}

Walk PathLanes::walk(std::uint32_t k) const {
  Walk walk;
  walk.path.ray = ray.ray(k);
  walk.path.throughput = throughput[k];
  walk.path.compression = compression[k];
  walk.path.last_pdf = last_pdf[k];
  walk.path.depth = depth[k];
  walk.path.medium = medium[k];
  walk.rng = samplers.sampler(k);
  walk.sample = sample[k];
  return walk;
}

void PathLanes::set(std::uint32_t k, const Walk& walk) {
  ray.set(k, walk.path.ray);
  throughput.set(k, walk.path.throughput);
  compression[k] = walk.path.compression;
  last_pdf[k] = walk.path.last_pdf;
  depth[k] = walk.path.depth;
  medium[k] = walk.path.medium;
  samplers.set(k, walk.rng);
  sample[k] = walk.sample;
}

void PathLanes::copy(std::uint32_t from, std::uint32_t to) {
  ray.origin.set(to, ray.origin[from]);
  ray.direction.set(to, ray.direction[from]);
  throughput.set(to, throughput[from]);
  compression[to] = compression[from];
  last_pdf[to] = last_pdf[from];
  depth[to] = depth[from];
  samplers.copy(from, to);
  sample[to] = sample[from];
  medium[to] = medium[from];
}

void PathLanes::bounce(const PreparedScene& scene, std::uint32_t count, std::span<const std::uint32_t> diffuse) {
  samplers.next2(count, direct_.random[0], direct_.random[1]);
  samplers.next2(count, choice_, roulette_);
  samplers.next2(count, random_[0], random_[1]);
  sample_lights(scene, count, diffuse);
  light_surfaces(count);
  scatter(count);
  reflect(count);
  go_on(count);
}

void PathLanes::sample_lights(const PreparedScene& scene, std::uint32_t count,
                              std::span<const std::uint32_t> diffuse) {
  direct_.point = surfaces.position;
  std::uint32_t others[kLanes];
  const std::uint32_t other_count = scene.lights.begin_direct(scene.scene, diffuse, choice_, direct_, others);
  direct_.sample(count);
  for (std::uint32_t i = 0; i < other_count; ++i) {
    const std::uint32_t k = others[i];
    const Vec3 random{direct_.random[0][k], direct_.random[1][k], choice_[k]};
    direct_.set(k, scene.lights.sample_direct(scene.scene, surfaces.position[k], random));
  }
}

void PathLanes::light_surfaces(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec3 wi = direct_.wi[i];
    const Vec3 ng = surfaces.ng[i];
    const float cosine = choose(glm::dot(wi, ng) > 0, std::max(glm::dot(wi, surfaces.ns[i]), 0.0f), 0);
    const float pdf = cosine * kInvPi;   // of going on that way
    const float pdf_direct = direct_.pdf_w[i];
    const float weight = choose(pdf_direct > 0, power_heuristic(pdf_direct, pdf), 1);
    light.set(i, throughput[i] * albedo[i] * direct_.radiance[i] * (pdf * weight));
    const Vec3 from = spawn_point(surfaces.position[i], ng, surfaces.extent[i], ng);
    const bool infinite = direct_.infinite[i] != 0;
    shadow.origin.set(i, from);
    shadow.direction.set(i, choose(infinite, wi, direct_.target[i] - from));
    shadow.t_max[i] = choose(infinite, kInfinity, 1);
  }
}

// The next directions from diffuse surfaces.
void PathLanes::scatter(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Vec3 local = square_to_cosine_hemisphere({random_[0][i], random_[1][i]});
    out_.set(i, Frame(surfaces.ns[i]).to_world(local));
    last_pdf[i] = local.z * kInvPi;
  }
}

// Those from mirrors and glass, in their lanes; and what is kept of the throughput. Where a shading normal would send
// them to the wrong side of the surface, it is taken as flat.
void PathLanes::reflect(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) reflect(i, surfaces.ns[i]);
  for (std::uint32_t i = 0; i < count; ++i) {
    if ((kept_[i] == 0) & (shading[i] != Shading::diffuse)) reflect(i, surfaces.ng[i]);
  }
}

[[gnu::always_inline]] inline void PathLanes::reflect(std::uint32_t i, const Vec3& n) {
  const bool specular = shading[i] != Shading::diffuse, glass = shading[i] == Shading::glass;
  const float eta = choose(surfaces.side[i] > 0, ior[i], 1 / ior[i]);
  SpecularBounce bounce = specular_bounce(ray.direction[i], n, glass, eta, random_[0][i]);
  bounce.out = choose(specular, bounce.out, out_[i]);
  const bool valid = bounce.valid(surfaces.ng[i]) & (specular | (last_pdf[i] > 0));   // diffuse ones are never refracted
  squeeze_[i] = choose(bounce.refracted != 0, eta * eta, 1);
  const bool clear = glass & (bounce.refracted == 0);
  kept_[i] = choose(valid, 1 / squeeze_[i], 0);
  reflected_.set(i, throughput[i] * choose(clear, Rgb(1), albedo[i]) * kept_[i]);
  out_.set(i, bounce.out);
  last_pdf[i] = choose(specular, 0, last_pdf[i]);
}

void PathLanes::go_on(std::uint32_t count) {
  const std::uint32_t end = whole_vectors(count);
  for (std::uint32_t i = 0; i < end; ++i) {
    const Rgb reflected = reflected_[i];
    const Vec3 out = out_[i];
    compression[i] *= squeeze_[i];
    const float survival = roulette_survival(reflected, compression[i], depth[i]);
    throughput.set(i, reflected * choose(roulette_[i] < survival, 1 / survival, 0));
    ray.origin.set(i, spawn_point(surfaces.position[i], surfaces.ng[i], surfaces.extent[i], out));
    ray.direction.set(i, out);
    ++depth[i];
  }
}

}  // namespace photond
