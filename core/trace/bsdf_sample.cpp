// How a Bsdf draws directions: by lobe, GGX by visible normals (Heitz 2018).
#include <algorithm>
#include <cmath>

#include "core/math/warp.h"
#include "core/trace/bsdf.h"

namespace photond {

std::optional<BsdfSample> Bsdf::sample(const Vec3& u, LobeMask mask, Transport transport) const {
  std::optional<BsdfSample> result(std::in_place);
  if (!sample_lobe(u, mask & lobes(), transport, *result)) result.reset();
  return result;
}

bool Bsdf::sample_lobe(const Vec3& u, LobeMask mask, Transport transport, BsdfSample& out) const {
  if (mask == kDiffuseLobe) return sample_diffuse(Vec2(u), mask, transport, out);
  float choice = u.z;
  for (LobeMask lobe = 1; lobe < kAllLobes; lobe <<= 1) {
    if ((mask & lobe) == 0) continue;
    const float p = selection(lobe, mask);
    // The last lobe of the mask takes what rounding leaves.
    if (choice >= p && (mask & ~((lobe << 1) - 1)) != 0) {
      choice -= p;
      continue;
    }
    if (p <= 0) return false;
    if (lobe == kDiffuseLobe) return sample_diffuse(Vec2(u), mask, transport, out);
    if (lobe == kReflectionLobe) return sample_reflection(Vec2(u), mask, transport, out);
    if (lobe == kClearcoatLobe) return sample_clearcoat(Vec2(u), mask, transport, out);
    if (lobe == kSheenLobe) return sample_sheen(Vec2(u), mask, transport, out);
    return sample_glass(Vec2(u), std::min(choice / p, 0x1.fffffep-1f), mask, transport, out);
  }
  return false;
}

bool Bsdf::sample_diffuse(const Vec2& u, LobeMask mask, Transport transport, BsdfSample& out) const {
  const Vec3 wi = square_to_cosine_hemisphere(u);
  if (mask != kDiffuseLobe) return finish(wi, kDiffuseLobe, mask, transport, out);
  // The common case, alone and without division: f·cos/pdf is the albedo.
  out.wi = frame_.to_world(wi);
  out.weight = diffuse_ * (layer_out_ * layer_.through(wi) * through_tops(wi, out.wi));
  out.pdf_w = wi.z * kInvPi;
  out.lobe = kDiffuseLobe;
  return wi.z > 0 && glm::dot(out.wi, ng_) > 0;
}

bool Bsdf::sample_reflection(const Vec2& u, LobeMask mask, Transport transport, BsdfSample& out) const {
  if (smooth()) {
    if (flat(kReflectionLobe)) return about_geometric_normal().sample_smooth_reflection(mask, out);
    return sample_smooth_reflection(mask, out);
  }
  const Vec3 h = facets_.sample_visible(wo_, u);
  const Vec3 wi = 2 * glm::dot(wo_, h) * h - wo_;
  return wi.z > 0 && finish(wi, kReflectionLobe, mask, transport, out);
}

bool Bsdf::sample_smooth_reflection(LobeMask mask, BsdfSample& out) const {
  const Vec3 wi{-wo_.x, -wo_.y, wo_.z};
  out.wi = frame_.to_world(wi);
  out.weight = reflection_fresnel(wo_.z) * (below_tops(wi, out.wi) / selection(kReflectionLobe, mask));
  out.lobe = kReflectionLobe;
  out.delta = true;
  return same_side(wi, out.wi);
}

bool Bsdf::sample_clearcoat(const Vec2& u, LobeMask mask, Transport transport, BsdfSample& out) const {
  if (coat_->smooth()) {
    if (flat(kClearcoatLobe)) return about_geometric_normal().sample_smooth_clearcoat(mask, out);
    return sample_smooth_clearcoat(mask, out);
  }
  const Vec3 wi = frame_.to_local(coat_->sample(u));
  return wi.z > 0 && finish(wi, kClearcoatLobe, mask, transport, out);
}

bool Bsdf::sample_smooth_clearcoat(LobeMask mask, BsdfSample& out) const {
  out.wi = coat_->mirrored();
  out.weight = Rgb(coat_->reflectance() / selection(kClearcoatLobe, mask));
  out.lobe = kClearcoatLobe;
  out.delta = true;
  return glm::dot(out.wi, ng_) > 0;
}

bool Bsdf::sample_sheen(const Vec2& u, LobeMask mask, Transport transport, BsdfSample& out) const {
  return finish(square_to_cosine_hemisphere(u), kSheenLobe, mask, transport, out);
}

bool Bsdf::sample_glass(const Vec2& u, float choice, LobeMask mask, Transport transport, BsdfSample& out) const {
  if (smooth()) {
    if (flat(kGlassLobe)) return about_geometric_normal().sample_smooth_glass(choice, mask, transport, out);
    return sample_smooth_glass(choice, mask, transport, out);
  }
  const Vec3 h = facets_.sample_visible(wo_, u);
  const float cos_h = glm::dot(wo_, h);
  if (cos_h <= 0) return false;
  float cos_t = 0;
  const bool reflected = choice < glass_reflectance(cos_h, cos_t);
  const Vec3 wi = glass_direction(h, cos_h, cos_t, reflected);
  if (reflected ? wi.z <= 0 : wi.z >= 0) return false;
  return finish(glm::normalize(wi), kGlassLobe, mask, transport, out);
}

bool Bsdf::sample_smooth_glass(float choice, LobeMask mask, Transport transport, BsdfSample& out) const {
  float cos_t = 0;
  const float fresnel = glass_reflectance(wo_.z, cos_t);
  const bool reflected = choice < fresnel;
  const Vec3 wi = glass_direction({0, 0, 1}, wo_.z, cos_t, reflected);
  out.wi = glm::normalize(frame_.to_world(wi));
  out.lobe = kGlassLobe;
  out.delta = true;
  out.transmitted = !reflected;
  const float scale = glass_weight_ * below_tops(wi, out.wi) / selection(kGlassLobe, mask);
  if (reflected) {
    out.weight = scale * glass_reflected(cos_t);
  } else {
    const float through = (1 - max_component(glass_specular_) * fresnel) / (1 - fresnel);
    const bool compressed = transport == Transport::radiance && !thin_;
    out.weight = scale * through * (compressed ? 1 / (eta_ * eta_) : 1.0f) * glass_tint_;
  }
  return same_side(wi, out.wi);
}

// Where a facet of normal h sends what comes from wo.
Vec3 Bsdf::glass_direction(const Vec3& h, float cos_h, float cos_t, bool reflected) const {
  if (reflected || thin_) {
    const Vec3 wi = 2 * cos_h * h - wo_;
    return reflected ? wi : Vec3(wi.x, wi.y, -wi.z);
  }
  return -wo_ / eta_ + (cos_h / eta_ - cos_t) * h;
}

bool Bsdf::finish(const Vec3& wi, LobeMask lobe, LobeMask mask, Transport transport, BsdfSample& out) const {
  out.wi = frame_.to_world(wi);
  out.lobe = lobe;
  out.transmitted = wi.z < 0;
  if (!same_side(wi, out.wi)) return false;
  out.pdf_w = pdf(out.wi, mask);
  if (!(out.pdf_w > 0)) return false;
  out.weight = eval(out.wi, mask, transport) * (std::abs(wi.z) / out.pdf_w);
  return true;
}

}  // namespace photond
