// glTF 2.0 appendix B; KHR_materials_specular, _transmission, _volume, _ior, _anisotropy, _clearcoat, _sheen.
// Walter et al. 2007: rough refraction. Heitz 2018: visible normals. Kelemen and Szirmay-Kalos 2001: layering.
#include "core/trace/bsdf.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/math/warp.h"
#include "core/trace/material_point.h"

namespace photond {

namespace {

constexpr float kMinCos = 1e-4f;   // of wo

float mean(const Rgb& c) { return (c.x + c.y + c.z) / 3; }

constexpr LobeMask kLobes[] = {kDiffuseLobe, kReflectionLobe, kGlassLobe, kClearcoatLobe, kSheenLobe};

int lobe_index(LobeMask lobe) { return std::countr_zero(lobe); }

// Gauss and Legendre: places in (0, 1) and their weights.
constexpr int kPlaces = 8;
constexpr float kPlace[kPlaces] = {0.0198550718f, 0.1016667613f, 0.2372337950f, 0.4082826788f,
                                   0.5917173212f, 0.7627662050f, 0.8983332387f, 0.9801449282f};
constexpr float kWeight[kPlaces] = {0.0506142681f, 0.1111905172f, 0.1568533229f, 0.1813418917f,
                                    0.1813418917f, 0.1568533229f, 0.1111905172f, 0.0506142681f};

Vec3 mirror_z(const Vec3& w) { return {w.x, w.y, -w.z}; }

float normal_reflectance(float ior) {
  if (ior == 0) return 1;  // KHR_materials_ior: 0 stands for an infinite index
  const float r = (ior - 1) / (ior + 1);
  return r * r;
}

}  // namespace

Bsdf::Bsdf(const Scene& scene, const SurfacePoint& surface, const Vec3& wo)
    : frame_(surface.ns), ng_(surface.ng) {
  if (!kAllFeatures) {
    diffuse_ = surface.material->base_color;
    select_[0] = 1;
    return;
  }
  const Material& material = *surface.material;
  if (material.bare_diffuse()) {
    diffuse_ = base_color_at(scene, surface);
    if (!is_black(diffuse_)) lobes_ = kDiffuseLobe;
    select_[0] = 1;
    return;
  }
  const MaterialPoint p = material_at(scene, surface);
  set_facets(scene, surface, p);
  const float dielectric = 1 - p.metallic;
  const float opaque = dielectric * (1 - p.transmission);
  diffuse_ = opaque * p.base_color;

  Rgb layer_f0(0);
  if (p.specular > 0) {
    layer_f0 = glm::min(normal_reflectance(material.ior) * p.specular_color, Rgb(1)) * p.specular;
  }
  if (p.specular > 0 || p.metallic > 0) {
    f0_ = p.metallic * p.base_color + opaque * layer_f0;
    // An ideal mirror reflects its colour at every angle; Schlick's rise towards grazing belongs to rough metal.
    const Rgb metal_f90 = smooth() ? p.base_color : Rgb(1);
    f90_ = p.metallic * metal_f90 + Rgb(opaque * p.specular);
  }
  glass_weight_ = dielectric * p.transmission;
  if (glass_weight_ > 0) {
    glass_tint_ = p.base_color;
    glass_specular_ = glm::min(p.specular * p.specular_color, Rgb(1));
    thin_ = material.thin_walled;
    float ior = surface.ior == 0 ? 1e6f : surface.ior;
    // The normals of rough facets follow from how they bend light.
    constexpr float kLeast = 1.00001f;
    if (!smooth() && !thin_ && std::abs(ior - 1) < kLeast - 1) ior = kLeast;
    eta_ = thin_ || surface.front ? ior : 1 / ior;
  }

  if (!is_black(diffuse_)) lobes_ |= kDiffuseLobe;
  if (!is_black(f90_) || !is_black(f0_)) lobes_ |= kReflectionLobe;
  if (glass_weight_ > 0) lobes_ |= kGlassLobe;
  const bool inside = glass_weight_ > 0 && !thin_ && !surface.front;
  const bool sheen = !is_black(p.sheen_color);
  if (p.clearcoat > 0) {
    const Vec3 normal = clearcoat_normal(scene, surface, wo);
    coat_.emplace(p.clearcoat, p.clearcoat_roughness * p.clearcoat_roughness, normal, wo, inside);
    if (!inside) lobes_ |= kClearcoatLobe;
  }
  if (sheen && !inside) lobes_ |= kSheenLobe;
  if (lobes_ == kDiffuseLobe) {
    select_[0] = 1;
    return;  // nothing of a bare Lambert surface depends on wo
  }
  wo_ = frame_.to_local(wo);
  wo_.z = std::max(wo_.z, kMinCos);
  if (sheen) sheen_.emplace(p.sheen_color, p.sheen_roughness, wo_.z, inside);
  if ((lobes_ & kDiffuseLobe) != 0 && (p.specular > 0 || coated() || sheened())) set_layer(layer_f0, p.specular);
  if ((lobes_ & (lobes_ - 1)) != 0) {
    set_selection();
  } else {
    std::ranges::fill(select_, 1.0f);  // a single lobe is always chosen
  }
}

void Bsdf::set_facets(const Scene& scene, const SurfacePoint& surface, const MaterialPoint& p) {
  const float alpha = p.roughness * p.roughness;
  facets_ = Ggx(alpha);
  if (!(p.anisotropy > 0)) return;
  const auto along = anisotropy_direction(scene, surface, p.anisotropy_direction);
  if (!along) return;
  const float across = std::max(alpha, kSmoothAlpha);
  facets_ = Ggx(across + (1 - across) * p.anisotropy * p.anisotropy, across);
  frame_ = Frame(frame_.n, *along);
}

void Bsdf::set_layer(const Rgb& f0, float f90) {
  layer_ = {max_component(f0), f90, facets_};
  const float through = mean_through();
  // Layers that reflect everything hide their base altogether.
  layer_out_ = through > 0 ? 1 / through : 0;
  layer_out_ *= layer_.through(wo_) * through_tops();
}

// The cosine-weighted mean of what all layers over the diffuse base let through.
float Bsdf::mean_through() const {
  if (!coated_here() && !sheened_here() && facets_.isotropic()) {
    const LayerAlbedo average = layer_albedo_average(facets_.least());
    return 1 - (layer_.f0 * average.a + layer_.f90 * average.b);
  }
  float sum = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const float sheen = sheened_here() ? sheen_->through(kPlace[i]) : 1;
    const float coat = coated_here() ? coat_->through(kPlace[i]) : 1;
    sum += 2 * kPlace[i] * kWeight[i] * (mean_through(kPlace[i]) * sheen) * coat;
  }
  return sum;
}

// The mean of the layer alone around the normal.
float Bsdf::mean_through(float cosine) const {
  if (facets_.isotropic()) return layer_.through({0, 0, cosine});
  constexpr int kTurns = 4;   // in a quarter: the others are alike
  const float sine = std::sqrt(1 - cosine * cosine);
  float sum = 0;
  for (int k = 0; k < kTurns; ++k) {
    const float turn = (static_cast<float>(k) + 0.5f) * (kPi / 2 / kTurns);
    sum += layer_.through({sine * std::cos(turn), sine * std::sin(turn), cosine}) / kTurns;
  }
  return sum;
}

// What a coat and a sheen on this side let through on the way to wo alone.
float Bsdf::through_tops() const {
  const float through = coated_here() ? coat_->through() : 1;
  return sheened_here() ? through * sheen_->through() : through;
}

// And on the way from wi.
float Bsdf::through_tops(const Vec3& wi, const Vec3& wi_world) const {
  const float through = coated_here() ? coat_->through(wi_world) : 1;
  return sheened_here() ? through * sheen_->through(wi.z) : through;
}

// What a coat leaves of a lobe below it but the diffuse one.
float Bsdf::below_coat(const Vec3& wi, bool transmitted) const {
  if (!coated()) return 1;
  if (transmitted && !thin_) return coat_->beyond() ? coat_->through(wi) : coat_->through();
  if (coat_->beyond()) return 1;
  return std::min(coat_->through(transmitted ? -wi : wi), coat_->through());
}

// And what a sheen does.
float Bsdf::below_sheen(const Vec3& wi) const {
  if (!sheened()) return 1;
  if (wi.z < 0 && !thin_) return sheen_->beyond() ? sheen_->through(-wi.z) : sheen_->through();
  if (sheen_->beyond()) return 1;
  return std::min(sheen_->through(std::abs(wi.z)), sheen_->through());
}

// Both together.
float Bsdf::below_tops(const Vec3& wi, const Vec3& wi_world) const {
  return below_coat(wi_world, wi.z < 0) * below_sheen(wi);
}

void Bsdf::set_selection() {
  const float through = through_tops();
  if ((lobes_ & kDiffuseLobe) != 0) {
    select_[0] = mean(diffuse_) * layer_.through(wo_) * through;
  }
  if ((lobes_ & kReflectionLobe) != 0) {
    select_[1] = mean(reflection_fresnel(wo_.z)) * through;
  }
  select_[2] = glass_weight_ * through;
  if ((lobes_ & kClearcoatLobe) != 0) select_[3] = coat_->reflectance();
  if ((lobes_ & kSheenLobe) != 0) select_[4] = mean(sheen_->reflectance()) * (coated() ? coat_->through() : 1);
}

float Bsdf::selection(LobeMask lobe, LobeMask mask) const {
  float sum = 0;
  for (const LobeMask l : kLobes) {
    if ((mask & l) != 0) sum += select_[lobe_index(l)];
  }
  return sum > 0 ? select_[lobe_index(lobe)] / sum : 0;
}

float Bsdf::share(LobeMask mask) const {
  float share = 0;
  for (const LobeMask l : kLobes) {
    if ((mask & lobes() & l) != 0) share += selection(l, lobes());
  }
  return share;
}

// The mean over the cosine of what the layers let through is what layer_out_ is divided by.
Rgb Bsdf::diffuse_albedo() const {
  return layer_out_ > 0 ? diffuse_ * (layer_.through(wo_) * through_tops()) : Rgb(0);
}

// Reflected directions must be above both horizons, transmitted ones below both.
bool Bsdf::above(const Vec3& wi) const { return std::min(glm::dot(wi, frame_.n), glm::dot(wi, ng_)) > 0; }

bool Bsdf::same_side(const Vec3& wi_local, const Vec3& wi) const { return wi_local.z * glm::dot(wi, ng_) > 0; }

Rgb Bsdf::reflection_fresnel(float cos_h) const { return f0_ + (f90_ - f0_) * schlick_weight(cos_h); }

Rgb Bsdf::eval_reflection(const Vec3& wi) const {
  const Vec3 sum = wo_ + wi;
  const float length = glm::length(sum);
  if (wi.z <= 0 || !(length > 0)) return Rgb(0);
  const Vec3 h = sum / length;
  const float common = facets_.d(h) * facets_.g2(wo_, wi) / (4 * wo_.z * wi.z);
  return common * reflection_fresnel(glm::dot(wo_, h));
}

float Bsdf::smooth_glass_reflectance() const {
  if (lobes() != kGlassLobe || !smooth()) return 0;
  if (flat(kGlassLobe)) return about_geometric_normal().smooth_glass_reflectance();
  float cos_t = 0;
  return glass_reflectance(wo_.z, cos_t);
}

float Bsdf::glass_reflectance(float cos_h, float& cos_t) const { return fresnel_dielectric(cos_h, eta_, cos_t); }

Rgb Bsdf::eval_glass(const Vec3& wi, Transport transport) const {
  if (wi.z == 0) return Rgb(0);
  float cos_t = 0;
  if (wi.z > 0 || thin_) {
    const Vec3 reflected = wi.z > 0 ? wi : mirror_z(wi);
    const Vec3 h = glm::normalize(wo_ + reflected);
    const float fresnel = glass_reflectance(glm::dot(wo_, h), cos_t);
    const float common = facets_.d(h) * facets_.g2(wo_, reflected) / (4 * wo_.z * reflected.z);
    const Rgb part = wi.z > 0 ? glass_reflected(cos_t) * fresnel : glass_tint_ * (1 - max_component(glass_specular_) * fresnel);
    return glass_weight_ * common * part;
  }
  Vec3 h = wo_ + eta_ * wi;
  const float length = glm::length(h);
  if (!(length > 0)) return Rgb(0);
  h /= h.z < 0 ? -length : length;
  const float cos_o = glm::dot(wo_, h);
  const float cos_i = glm::dot(wi, h);
  if (cos_o <= 0 || cos_i >= 0) return Rgb(0);
  const float fresnel = glass_reflectance(cos_o, cos_t);
  if (cos_t == 0) return Rgb(0);
  const float denominator = cos_o + eta_ * cos_i;
  // Walter et al. eq. 21 for radiance; flux is not compressed by the index.
  float f = facets_.d(h) * facets_.g2(wo_, wi) * std::abs(cos_o * cos_i / (wo_.z * wi.z)) /
            (denominator * denominator);
  if (transport == Transport::flux) f *= eta_ * eta_;
  return glass_weight_ * f * glass_tint_ * (1 - max_component(glass_specular_) * fresnel);
}

float Bsdf::pdf_glass(const Vec3& wi) const {
  if (wi.z == 0) return 0;
  float cos_t = 0;
  if (wi.z > 0 || thin_) {
    const Vec3 reflected = wi.z > 0 ? wi : mirror_z(wi);
    const Vec3 h = glm::normalize(wo_ + reflected);
    const float cos_h = glm::dot(wo_, h);
    const float fresnel = glass_reflectance(cos_h, cos_t);
    return (wi.z > 0 ? fresnel : 1 - fresnel) * facets_.visible_pdf(wo_, h) / (4 * cos_h);
  }
  Vec3 h = wo_ + eta_ * wi;
  const float length = glm::length(h);
  if (!(length > 0)) return 0;
  h /= h.z < 0 ? -length : length;
  const float cos_o = glm::dot(wo_, h);
  const float cos_i = glm::dot(wi, h);
  if (cos_o <= 0 || cos_i >= 0) return 0;
  const float fresnel = glass_reflectance(cos_o, cos_t);
  const float denominator = cos_o + eta_ * cos_i;
  return (1 - fresnel) * facets_.visible_pdf(wo_, h) * eta_ * eta_ * std::abs(cos_i) / (denominator * denominator);
}

Rgb Bsdf::eval(const Vec3& wi_world, LobeMask mask, Transport transport) const {
  if (lobes() == kDiffuseLobe) return (mask & kDiffuseLobe) != 0 && above(wi_world) ? diffuse_ * kInvPi : Rgb(0);
  mask &= lobes() & ~delta_lobes();
  const Vec3 wi = frame_.to_local(wi_world);
  if (mask == kNoLobe || !same_side(wi, wi_world)) return Rgb(0);
  Rgb f(0);
  if ((mask & kDiffuseLobe) != 0 && wi.z > 0) {
    f += diffuse_ * (kInvPi * layer_out_ * layer_.through(wi) * through_tops(wi, wi_world));
  }
  if ((mask & kReflectionLobe) != 0 && wi.z > 0) f += eval_reflection(wi) * below_tops(wi, wi_world);
  if ((mask & kGlassLobe) != 0) f += eval_glass(wi, transport) * below_tops(wi, wi_world);
  if ((mask & kClearcoatLobe) != 0 && wi.z > kMinCos) f += Rgb(coat_->scattered(wi_world) / wi.z);
  if ((mask & kSheenLobe) != 0 && wi.z > 0) f += sheen_->eval(wo_, wi) * below_coat(wi_world, false);
  return f;
}

float Bsdf::pdf(const Vec3& wi_world, LobeMask mask) const {
  mask &= lobes();
  const LobeMask spread = mask & ~delta_lobes();
  const Vec3 wi = frame_.to_local(wi_world);
  float pdf = 0;
  if ((spread & kDiffuseLobe) != 0) pdf += selection(kDiffuseLobe, mask) * square_to_cosine_hemisphere_pdf(wi);
  if ((spread & kReflectionLobe) != 0 && wi.z > 0) {
    const Vec3 h = glm::normalize(wo_ + wi);
    pdf += selection(kReflectionLobe, mask) * facets_.visible_pdf(wo_, h) / (4 * glm::dot(wo_, h));
  }
  if ((spread & kGlassLobe) != 0) pdf += selection(kGlassLobe, mask) * pdf_glass(wi);
  if ((spread & kClearcoatLobe) != 0) pdf += selection(kClearcoatLobe, mask) * coat_->pdf(wi_world);
  if ((spread & kSheenLobe) != 0) pdf += selection(kSheenLobe, mask) * square_to_cosine_hemisphere_pdf(wi);
  return pdf;
}

bool Bsdf::flat(LobeMask lobe) const {
  if (!may_flatten_ || normal(lobe) == ng_) return false;
  if (lobe == kClearcoatLobe) return !(glm::dot(coat_->mirrored(), ng_) > 0);
  if (!same_side({-wo_.x, -wo_.y, wo_.z})) return true;
  if (lobe != kGlassLobe) return false;
  float cos_t = 0;
  glass_reflectance(wo_.z, cos_t);
  return cos_t > 0 && !same_side(glass_direction({0, 0, 1}, wo_.z, cos_t, false));
}

Bsdf Bsdf::about_shading_normal() const {
  Bsdf same = *this;
  same.may_flatten_ = false;
  return same;
}

Bsdf Bsdf::about_geometric_normal() const {
  Bsdf flat = *this;
  flat.frame_ = Frame(ng_);
  flat.wo_ = flat.frame_.to_local(frame_.to_world(wo_));
  flat.wo_.z = std::max(flat.wo_.z, kMinCos);
  if (coated()) flat.coat_ = coat_->turned(ng_);
  if (sheened()) flat.sheen_ = sheen_->turned(flat.wo_.z);
  flat.may_flatten_ = false;
  return flat;
}

}  // namespace photond
