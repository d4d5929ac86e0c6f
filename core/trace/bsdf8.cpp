// As bsdf.cpp and microfacet.h.
#include "core/trace/bsdf8.h"

namespace photond {

namespace {

Float8 lambda(const Vec3x8& w, float alpha_sq) {
  const Float8 tan_sq = (w.x * w.x + w.y * w.y) / max8(w.z * w.z, Float8{} + 1e-20f);
  return 0.5f * (sqrt8(1 + alpha_sq * tan_sq) - 1);
}

Float8 schlick_weight(const Float8& cosine) {
  const Float8 m = min8(max8(1 - cosine, Float8{}), Float8{} + 1);
  return m * m * (m * m) * m;
}

}  // namespace

Bsdf8::Bsdf8(const Bsdf& bsdf, LobeMask mask) : frame_(bsdf.frame_), ng_(bsdf.ng_), wo_(bsdf.wo_) {
  mask &= bsdf.lobes() & ~bsdf.delta_lobes();
  if ((mask & kDiffuseLobe) != 0) {
    diffuse_ = bsdf.diffuse_ * (kInvPi * bsdf.layer_out_);
    if (bsdf.layered()) layer_.emplace(bsdf.layer_f0_, bsdf.layer_f90_, bsdf.alpha_);
  }
  reflects_ = (mask & kReflectionLobe) != 0;
  if (!reflects_) return;
  f0_ = bsdf.f0_;
  f90_ = bsdf.f90_;
  alpha_sq_ = bsdf.alpha_ * bsdf.alpha_;
  lambda_out_ = ggx_lambda(wo_, bsdf.alpha_);
}

Vec3x8 Bsdf8::eval(const Vec3x8& wi) const {
  const Float8 cosine = dot(frame_.n, wi);
  const Mask8 above = (cosine > 0) & (dot(ng_, wi) > 0);
  Vec3x8 f = diffuse_ * (layer_ ? (*layer_)(cosine) : Float8{} + 1);
  if (reflects_) f = f + reflection({dot(frame_.s, wi), dot(frame_.t, wi), cosine});
  return choose8(above, f, Vec3x8{});
}

// `wi` is local.
Vec3x8 Bsdf8::reflection(const Vec3x8& wi) const {
  const Vec3x8 h = wi + wo_;   // of any length
  const Float8 length_sq = dot(h, h);
  const Float8 t = h.x * h.x + h.y * h.y + alpha_sq_ * h.z * h.z;
  const Float8 d = (alpha_sq_ * kInvPi) * (length_sq * length_sq) / (t * t);
  const Float8 g = 1 / (1 + lambda_out_ + lambda(wi, alpha_sq_));
  const Float8 schlick = schlick_weight(dot(wo_, h) / sqrt8(length_sq));
  const Float8 common = d * g / (4 * wo_.z * wi.z);
  return (f0_ * (1 - schlick) + f90_ * schlick) * common;
}

}  // namespace photond
