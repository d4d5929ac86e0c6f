// As bsdf.cpp, clearcoat.cpp and microfacet.h.
#include "core/trace/bsdf8.h"

namespace photond {

namespace {

Float8 schlick_weight(const Float8& cosine) {
  const Float8 m = min8(max8(1 - cosine, Float8{}), Float8{} + 1);
  return m * m * (m * m) * m;
}

}  // namespace

Bsdf8::Reflection::Reflection(const Frame& about, const Ggx& of, const Vec3& out, const Rgb& at_normal,
                              const Rgb& at_grazing)
    : frame(about), facets(of), wo(out), f0(at_normal), f90(at_grazing), lambda_out(of.lambda(out)) {}

Float8 Bsdf8::Reflection::lambda(const Vec3x8& w) const {
  const Float8 across = w.x * w.x * facets.ratio_ + w.y * w.y * facets.inverse_;
  return 0.5f * (sqrt8(1 + facets.product_ * (across / max8(w.z * w.z, Float8{} + 1e-20f))) - 1);
}

Vec3x8 Bsdf8::Reflection::times_cosine(const Vec3x8& direction) const {
  const Vec3x8 wi{dot(frame.s, direction), dot(frame.t, direction), dot(frame.n, direction)};
  const Vec3x8 h = wi + wo;   // of any length
  const Float8 length_sq = dot(h, h);
  const Float8 t = h.x * h.x * facets.inverse_ + h.y * h.y * facets.ratio_ + facets.product_ * h.z * h.z;
  const Float8 d = (facets.product_ * kInvPi) * (length_sq * length_sq) / (t * t);
  const Float8 g = 1 / (1 + lambda_out + lambda(wi));
  const Float8 schlick = schlick_weight(dot(wo, h) / sqrt8(length_sq));
  const Float8 common = d * g / (4 * wo.z);
  return choose8(wi.z > 0, (f0 * (1 - schlick) + f90 * schlick) * common, Vec3x8{});
}

Bsdf8::Bsdf8(const Bsdf& bsdf, LobeMask mask) : frame_(bsdf.frame_), ng_(bsdf.ng_) {
  mask &= bsdf.lobes() & ~bsdf.delta_lobes();
  if ((mask & kDiffuseLobe) != 0) {
    diffuse_ = bsdf.diffuse_ * (kInvPi * bsdf.layer_out_);
    if (bsdf.layer_.reflects()) layer_.emplace(bsdf.layer_);
  }
  if ((mask & kReflectionLobe) != 0) reflection_.emplace(frame_, bsdf.facets_, bsdf.wo_, bsdf.f0_, bsdf.f90_);
  if (bsdf.sheened_here()) {
    sheen_.emplace(*bsdf.sheen_, bsdf.wo_);
    shines_ = (mask & kSheenLobe) != 0;
  }
  if (!bsdf.coated_here()) return;
  const Clearcoat& coat = *bsdf.coat_;
  const float f0 = coat.amount_ * Clearcoat::kF0, f90 = coat.amount_;
  coat_.emplace(coat.normal(), LayerTransmission({f0, f90, coat.facets_}), coat.through());
  if ((mask & kClearcoatLobe) != 0) clearcoat_.emplace(coat.frame_, coat.facets_, coat.wo_, Rgb(f0), Rgb(f90));
}

// What the layer lets through to the base.
Float8 Bsdf8::to_base(const Vec3x8& wi, const Float8& cosine) const {
  if (!layer_) return Float8{} + 1;
  return layer_->isotropic() ? (*layer_)(cosine) : (*layer_)({dot(frame_.s, wi), dot(frame_.t, wi), cosine});
}

Vec3x8 Bsdf8::eval(const Vec3x8& wi) const {
  const Float8 cosine = dot(frame_.n, wi);
  const Mask8 above = (cosine > 0) & (dot(ng_, wi) > 0);
  Vec3x8 f = diffuse_ * to_base(wi, cosine);
  Float8 below_coat = Float8{} + 1, below = below_coat;   // is left of lobes but the diffuse one
  if (coat_) {
    const Float8 through = coat_->through(dot(coat_->normal, wi));
    f = f * through;
    below = below_coat = min8(through, Float8{} + coat_->through_out);
  }
  if (sheen_) {
    const Float8 through = sheen_->through(cosine);
    f = f * through;
    below = below * min8(through, Float8{} + sheen_->through());
  }
  if (reflection_) f = f + reflection_->times_cosine(wi) * (below / cosine);
  if (clearcoat_) f = f + clearcoat_->times_cosine(wi) * (1 / cosine);
  if (shines_) f = f + sheen_->eval({dot(frame_.s, wi), dot(frame_.t, wi), cosine}) * below_coat;
  return choose8(above, f, Vec3x8{});
}

}  // namespace photond
