// glTF 2.0 appendix B; KHR_materials_specular, _transmission, _volume, _ior, _clearcoat, _sheen.
// Walter et al. 2007: rough refraction. Heitz 2018: visible normals. Kelemen and Szirmay-Kalos 2001: layering.
#include "core/trace/bsdf.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/math/warp.h"
#include "core/trace/layer.h"
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
  alpha_ = p.roughness * p.roughness;
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
    const Rgb metal_f90 = alpha_ < kSmoothAlpha ? p.base_color : Rgb(1);
    f90_ = p.metallic * metal_f90 + Rgb(opaque * p.specular);
  }
  glass_weight_ = dielectric * p.transmission;
  if (glass_weight_ > 0) {
    glass_tint_ = p.base_color;
    glass_specular_ = glm::min(p.specular * p.specular_color, Rgb(1));
    thin_ = material.thin_walled;
    float ior = surface.ior == 0 ? 1e6f : surface.ior;
    // The normals of rough facets follow from how they bend light.
    if (alpha_ >= kSmoothAlpha && !thin_) ior = std::max(ior, 1.00001f);
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

void Bsdf::set_layer(const Rgb& f0, float f90) {
  layer_f0_ = max_component(f0);
  layer_f90_ = f90;
  const float through = mean_through();
  // Layers that reflect everything hide their base altogether.
  layer_out_ = through > 0 ? 1 / through : 0;
  layer_out_ *= layer_scale(wo_.z) * through_tops();
}

// The cosine-weighted mean of what all layers over the diffuse base let through.
float Bsdf::mean_through() const {
  if (!coated_here() && !sheened_here()) {
    const LayerAlbedo average = layer_albedo_average(alpha_);
    return 1 - (layer_f0_ * average.a + layer_f90_ * average.b);
  }
  float sum = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const float sheen = sheened_here() ? sheen_->through(kPlace[i]) : 1;
    const float coat = coated_here() ? coat_->through(kPlace[i]) : 1;
    sum += 2 * kPlace[i] * kWeight[i] * (layer_scale(kPlace[i]) * sheen) * coat;
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

float Bsdf::layer_scale(float cos_i) const {
  if (!layered()) return 1;
  const LayerAlbedo e = layer_albedo(cos_i, alpha_);
  return std::max(0.0f, 1 - (layer_f0_ * e.a + layer_f90_ * e.b));
}

void Bsdf::set_selection() {
  const float through = through_tops();
  if ((lobes_ & kDiffuseLobe) != 0) {
    select_[0] = mean(diffuse_) * layer_scale(wo_.z) * through;
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
  return layer_out_ > 0 ? diffuse_ * (layer_scale(wo_.z) * through_tops()) : Rgb(0);
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
  const float common = ggx_d(h, alpha_) * ggx_g2(wo_, wi, alpha_) / (4 * wo_.z * wi.z);
  return common * reflection_fresnel(glm::dot(wo_, h));
}

float Bsdf::smooth_glass_reflectance() const {
  if (lobes() != kGlassLobe || alpha_ >= kSmoothAlpha) return 0;
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
    const float common = ggx_d(h, alpha_) * ggx_g2(wo_, reflected, alpha_) / (4 * wo_.z * reflected.z);
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
  float f = ggx_d(h, alpha_) * ggx_g2(wo_, wi, alpha_) * std::abs(cos_o * cos_i / (wo_.z * wi.z)) /
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
    return (wi.z > 0 ? fresnel : 1 - fresnel) * ggx_visible_pdf(wo_, h, alpha_) / (4 * cos_h);
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
  return (1 - fresnel) * ggx_visible_pdf(wo_, h, alpha_) * eta_ * eta_ * std::abs(cos_i) / (denominator * denominator);
}

Rgb Bsdf::eval(const Vec3& wi_world, LobeMask mask, Transport transport) const {
  if (lobes() == kDiffuseLobe) return (mask & kDiffuseLobe) != 0 && above(wi_world) ? diffuse_ * kInvPi : Rgb(0);
  mask &= lobes() & ~delta_lobes();
  const Vec3 wi = frame_.to_local(wi_world);
  if (mask == kNoLobe || !same_side(wi, wi_world)) return Rgb(0);
  Rgb f(0);
  if ((mask & kDiffuseLobe) != 0 && wi.z > 0) {
    f += diffuse_ * (kInvPi * layer_out_ * layer_scale(wi.z) * through_tops(wi, wi_world));
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
    pdf += selection(kReflectionLobe, mask) * ggx_visible_pdf(wo_, h, alpha_) / (4 * glm::dot(wo_, h));
  }
  if ((spread & kGlassLobe) != 0) pdf += selection(kGlassLobe, mask) * pdf_glass(wi);
  if ((spread & kClearcoatLobe) != 0) pdf += selection(kClearcoatLobe, mask) * coat_->pdf(wi_world);
  if ((spread & kSheenLobe) != 0) pdf += selection(kSheenLobe, mask) * square_to_cosine_hemisphere_pdf(wi);
  return pdf;
}

std::optional<BsdfSample> Bsdf::sample(const Vec3& u, LobeMask mask, Transport transport) const {
  std::optional<BsdfSample> result(std::in_place);
  if (!sample_lobe(u, mask & lobes(), transport, *result)) result.reset();
  return result;
}

bool Bsdf::sample_lobe(const Vec3& u, LobeMask mask, Transport transport, BsdfSample& out) const {
  if (mask == kDiffuseLobe) return sample_diffuse(Vec2(u), mask, transport, out);
  float choice = u.z;
  for (const LobeMask lobe : kLobes) {
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
  out.weight = diffuse_ * (layer_out_ * layer_scale(wi.z) * through_tops(wi, out.wi));
  out.pdf_w = wi.z * kInvPi;
  out.lobe = kDiffuseLobe;
  return wi.z > 0 && glm::dot(out.wi, ng_) > 0;
}

bool Bsdf::sample_reflection(const Vec2& u, LobeMask mask, Transport transport, BsdfSample& out) const {
  if (alpha_ < kSmoothAlpha) {
    if (flat(kReflectionLobe)) return about_geometric_normal().sample_smooth_reflection(mask, out);
    return sample_smooth_reflection(mask, out);
  }
  const Vec3 h = ggx_sample_visible(wo_, alpha_, u);
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
  if (alpha_ < kSmoothAlpha) {
    if (flat(kGlassLobe)) return about_geometric_normal().sample_smooth_glass(choice, mask, transport, out);
    return sample_smooth_glass(choice, mask, transport, out);
  }
  const Vec3 h = ggx_sample_visible(wo_, alpha_, u);
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
    return reflected ? wi : mirror_z(wi);
  }
  return -wo_ / eta_ + (cos_h / eta_ - cos_t) * h;
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
