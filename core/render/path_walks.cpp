// Veach 1997: next-event estimation and multiple importance sampling.
#include "core/render/path_walks.h"

namespace photond {

void PathWalks::run(std::span<const Ray> rays, std::span<const CameraSampler> samplers,
                    std::span<RadianceSample> samples) {
  bounces_.begin(samples, {});
  traced_ = begun_ = 0;
  for (;;) {
    intersect();
    begin(rays, samplers);
    if (count_ == 0) break;
    advance();
  }
  bounces_.shadows.trace();
}

void PathWalks::intersect() {
  scene_.accel.intersect(paths_.ray, count_, Coherence::none, hits_);
  Subset gone;
  for (std::uint32_t k = 0; k < count_; ++k) gone.add(k, hits_.instance[k] == Hit::kNone);
  if (scene_.scene.environment.active()) {
    for (const std::uint32_t k : gone) bounces_.add_environment(paths_.walk(k));
  }
  remove(gone);
}

// Begins paths in the lanes that are free. Rays from the camera are traced beside one another, which is quicker.
void PathWalks::begin(std::span<const Ray> rays, std::span<const CameraSampler> samplers) {
  while (count_ < kLanes && begun_ < rays.size()) {
    if (begun_ == traced_) {
      const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(kLanes, rays.size() - traced_));
      for (std::uint32_t k = 0; k < count; ++k) camera_rays_.set(k, rays[traced_ + k]);
      scene_.accel.intersect(camera_rays_, count, Coherence::high, camera_hits_);
      traced_ += count;
    }
    const std::size_t i = begun_++;
    const Hit hit = camera_hits_[i % kLanes];
    paths_.begin(count_, rays[i], samplers[i], static_cast<std::uint32_t>(i), start_of(scene_, settings_, rays[i]));
    if (hit.found()) {
      hits_.set(count_++, hit);
    } else {
      bounces_.add_environment(paths_.walk(count_));
    }
  }
}

void PathWalks::advance() {
  meet_surfaces();
  advance_others();
  add_emissions();
  paths_.bounce(scene_, count_, {diffuse_.begin(), diffuse_.size});
  add_direct_light();
  for (std::uint32_t i = 0; i < others_.size; ++i) paths_.set(others_.lanes[i], walks_[i]);
  Subset ended;
  for (std::uint32_t k = 0; k < count_; ++k) ended.add(k, is_black(paths_.throughput[k]));
  remove(ended);
}

void PathWalks::meet_surfaces() {
  diffuse_.size = others_.size = emitters_.size = 0;
  for (std::uint32_t k = 0; k < count_; ++k) {
    const Hit hit = hits_[k];
    const PlacedMesh& mesh = scene_.placed[hit.instance];
    paths_.arrive(k, mesh, hit);
    const bool other = (mesh.shading == Shading::other) | paths_.medium[k].active() |
                       (paths_.depth[k] == settings_.max_depth) | scene_.lights.empty();
    others_.add(k, other);
    diffuse_.add(k, !other & (mesh.shading == Shading::diffuse));
    emitters_.add(k, !other & mesh.emissive);
  }
  paths_.find_surfaces(count_);
}

void PathWalks::advance_others() {
  for (std::uint32_t i = 0; i < others_.size; ++i) {
    const std::uint32_t k = others_.lanes[i];
    const Hit hit = hits_[k];
    Walk& walk = walks_[i];
    walk = paths_.walk(k);
    const PlacedMesh& mesh = scene_.placed[hit.instance];
    const bool alive =
        bounces_.advance(walk, hit, paths_.surfaces.surface(k, scene_.scene, mesh, walk.path.ray, hit));
    ++walk.path.depth;
    if (!alive) walk.path.throughput = Rgb(0);
  }
}

void PathWalks::add_emissions() {
  for (const std::uint32_t k : emitters_) {
    const Hit hit = hits_[k];
    bounces_.add_emission(paths_.walk(k), paths_.surfaces.point(k, scene_.scene, hit), hit.t);
  }
}

void PathWalks::add_direct_light() {
  for (const std::uint32_t k : diffuse_) bounces_.shadows.add(paths_.sample[k], paths_.shadow.ray(k), paths_.light[k]);
}

// Paths from the last lanes take the places of those that ended.
void PathWalks::remove(const Subset& ended) {
  for (std::uint32_t i = ended.size; i-- > 0;) {
    const std::uint32_t k = ended.lanes[i];
    if (k == --count_) continue;
    paths_.copy(count_, k);
    hits_.set(k, hits_[count_]);
  }
}

}  // namespace photond
