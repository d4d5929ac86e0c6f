// KHR_materials_clearcoat.
#include "core/trace/clearcoat.h"

#include <cmath>

#include "core/trace/layer.h"

namespace photond {

namespace {

constexpr float kMinCos = 1e-4f;   // of wo, as in Bsdf

}  // namespace

Clearcoat::Clearcoat(float amount, float alpha, const Vec3& normal, const Vec3& wo, bool beyond)
    : frame_(normal), wo_(frame_.to_local(wo)), facets_(alpha), amount_(amount), beyond_(beyond) {
  wo_.z = std::max(wo_.z, kMinCos);
  through_out_ = through(wo_.z);
}

float Clearcoat::through(float cosine) const {
  const LayerAlbedo e = layer_albedo(cosine, alpha());
  return 1 - amount_ * (kF0 * e.a + e.b);
}

float Clearcoat::through(const Vec3& w) const {
  const float cosine = glm::dot(w, frame_.n);
  return through(std::clamp(beyond_ ? -cosine : cosine, 0.0f, 1.0f));
}

float Clearcoat::scattered(const Vec3& wi_world) const {
  const Vec3 wi = frame_.to_local(wi_world);
  const Vec3 sum = wo_ + wi;
  const float length = glm::length(sum);
  if (smooth() || wi.z <= 0 || !(length > 0)) return 0;
  const Vec3 h = sum / length;
  return facets_.d(h) * facets_.g2(wo_, wi) / (4 * wo_.z) * fresnel(glm::dot(wo_, h));
}

float Clearcoat::pdf(const Vec3& wi_world) const {
  const Vec3 wi = frame_.to_local(wi_world);
  if (wi.z <= 0) return 0;
  const Vec3 h = glm::normalize(wo_ + wi);
  return facets_.visible_pdf(wo_, h) / (4 * glm::dot(wo_, h));
}

Vec3 Clearcoat::sample(const Vec2& u) const {
  const Vec3 h = facets_.sample_visible(wo_, u);
  return frame_.to_world(2 * glm::dot(wo_, h) * h - wo_);
}

Clearcoat Clearcoat::turned(const Vec3& normal) const {
  return {amount_, alpha(), normal, frame_.to_world(wo_), beyond_};
}

}  // namespace photond
