// KHR_materials_sheen. Estevez and Kulla 2017: Production Friendly Microfacet Sheen BRDF.
#include "core/trace/sheen.h"

#include <array>
#include <cmath>
#include <numbers>

#include "core/math/exp8.h"

namespace photond {

namespace {

constexpr float kMinCos = 1e-4f;          // as in Bsdf
constexpr float kMinRoughness = 0.1f;     // below it hardly anything is left but at the horizon
constexpr float kBoundedAlpha = 0.073f;   // from here on the fit of the masking reflects no more than there is
constexpr float kMost = 0.985f;           // of light that is reflected where it is bounded: the tables err by 1.4 %
constexpr float kMiddle = 0.5f;           // about it the logarithm of the masking is mirrored

float alpha_of(float roughness) {
  const float enough = std::clamp(roughness, kMinRoughness, 1.0f);
  return enough * enough;
}

// The density of normals is this times sin^(1/α).
float density_scale(float alpha) { return (2 + 1 / alpha) * (0.5f * kInvPi); }

// sin^(1/α) of a vector of any length; `exponent` is 1/2α.
float power_of_sine(const Vec3& h, float exponent) {
  const float across = h.x * h.x + h.y * h.y;
  return std::pow(across / (across + h.z * h.z), exponent);
}
Float8 power_of_sine(const Vec3x8& h, float exponent) {
  const Float8 across = h.x * h.x + h.y * h.y, least = Float8{} + 1e-30f;
  const Float8 sin_sq = across / max8(across + h.z * h.z, least);
  return exp2_8(exponent * log2_8(max8(sin_sq, least)));
}

// A function of roughness, at nodes evenly between the least and 1, and of a cosine.
struct Table {
  static constexpr int kRows = 32;
  std::array<CosineNodes, kRows> rows;

  static float roughness(int row) {
    return kMinRoughness + (1 - kMinRoughness) * static_cast<float>(row) / (kRows - 1);
  }

  // The row below a roughness, and how far it is on the way to the next.
  static int cell(float alpha, float& part) {
    const float s = std::max((std::sqrt(alpha) - kMinRoughness) / (1 - kMinRoughness), 0.0f) * (kRows - 1);
    const int row = std::min(static_cast<int>(s), kRows - 2);
    part = s - static_cast<float>(row);
    return row;
  }
  float at(float alpha, float cosine) const {
    float t = 0;
    const int i = cell(alpha, t);
    const float low = rows[i](cosine), high = rows[i + 1](cosine);
    return low + t * (high - low);
  }
  CosineNodes row(float alpha) const {
    float t = 0;
    const int i = cell(alpha, t);
    CosineNodes mixed;
    for (int j = 0; j < CosineNodes::kCount; ++j) {
      mixed.value[j] = rows[i].value[j] + t * (rows[i + 1].value[j] - rows[i].value[j]);
    }
    return mixed;
  }
};

// The share of light from a cosine that fibres reflect whose f is scaled by the lesser of `bound` of both cosines.
float integrate(float cos_o, float alpha, const SheenMasking& masking, const CosineNodes& bound) {
  constexpr int kHeights = 48, kTurns = 24;
  std::array<Vec3x8, kTurns / 8> turns;
  for (int k = 0; k < kTurns; ++k) {
    const float phi = kPi * (static_cast<float>(k) + 0.5f) / kTurns;
    turns[k / 8].x[k % 8] = std::cos(phi);
    turns[k / 8].y[k % 8] = std::sin(phi);
    turns[k / 8].z[k % 8] = 0;
  }
  const Vec3 wo{std::sqrt(1 - cos_o * cos_o), 0, cos_o};
  const float lambda_out = masking.lambda(cos_o), bound_out = bound(cos_o);
  double sum = 0;
  for (int i = 0; i < kHeights; ++i) {
    const float root = (static_cast<float>(i) + 0.5f) / kHeights;   // more at grazing angles
    const float cos_i = root * root, sin_i = std::sqrt(1 - cos_i * cos_i);
    Float8 density{};
    for (const Vec3x8& turn : turns) {
      density += power_of_sine(turn * (Float8{} + sin_i) + (wo + Vec3(0, 0, cos_i)), 0.5f / alpha);
    }
    const float scale = std::min(bound_out, bound(cos_i)) / ((1 + lambda_out + masking.lambda(cos_i)) * 4 * cos_o);
    sum += sum8(density) * (2 * root * scale);
  }
  return density_scale(alpha) * static_cast<float>(sum * (2 * kPi / (kHeights * kTurns)));
}

// Of white fibres: the share of light that they reflect, and what their f is scaled by where they would else reflect
// more than there is.
struct Tables {
  Table reflected, bound;

  Tables() {
    for (int i = 0; i < Table::kRows; ++i) {
      const float alpha = Table::roughness(i) * Table::roughness(i);
      std::ranges::fill(bound.rows[i].value, 1.0f);
      reflected.rows[i] = integrated(alpha, bound.rows[i]);
      if (alpha >= kBoundedAlpha) continue;
      for (int j = 0; j < CosineNodes::kCount; ++j) {
        bound.rows[i].value[j] = std::min(1.0f, kMost / reflected.rows[i].value[j]);
      }
      reflected.rows[i] = integrated(alpha, bound.rows[i]);
      for (float& share : reflected.rows[i].value) share = std::min(share, 1.0f);
    }
  }

  static CosineNodes integrated(float alpha, const CosineNodes& bound) {
    const SheenMasking masking(alpha);
    CosineNodes row;
    for (int j = 0; j < CosineNodes::kCount; ++j) {
      row.value[j] = integrate(std::clamp(CosineNodes::cosine(j), kMinCos, 1.0f), alpha, masking, bound);
    }
    return row;
  }
};

const Tables& tables() {
  static const Tables instance;
  return instance;
}

}  // namespace

SheenMasking::SheenMasking(float alpha) {
  const float t = (1 - alpha) * (1 - alpha);
  const auto mixed = [t](float rough, float smooth) { return rough + t * (smooth - rough); };
  a = mixed(21.5473f, 25.3245f);
  b = mixed(3.82987f, 3.32435f);
  c = mixed(0.19823f, 0.16801f);
  d = mixed(-1.97760f, -1.27393f);
  e = mixed(-4.32054f, -4.85967f);
}

float SheenMasking::exponent(float cosine) const {
  return a / (1 + b * std::pow(std::max(cosine, kMinCos), c)) + d * cosine + e;
}

float SheenMasking::lambda(float cosine) const {
  return std::exp(cosine < kMiddle ? exponent(cosine) : 2 * exponent(kMiddle) - exponent(1 - cosine));
}

Sheen::Sheen(const Rgb& color, float roughness, float cos_o, bool beyond)
    : color_(color), alpha_(alpha_of(roughness)), masking_(alpha_), beyond_(beyond) {
  lambda_out_ = masking_.lambda(cos_o);
  bound_out_ = bound(cos_o);
  reflected_out_ = tables().reflected.at(alpha_, cos_o);
  through_out_ = through(cos_o);
}

float Sheen::through(float cosine) const {
  return 1 - max_component(color_) * tables().reflected.at(alpha_, cosine);
}

float Sheen::bound(float cosine) const { return alpha_ < kBoundedAlpha ? tables().bound.at(alpha_, cosine) : 1; }

Rgb Sheen::eval(const Vec3& wo, const Vec3& wi) const {
  const float cos_i = std::max(wi.z, kMinCos);
  const float density = density_scale(alpha_) * power_of_sine(wo + wi, 0.5f / alpha_);
  const float unmasked = 1 / ((1 + lambda_out_ + masking_.lambda(cos_i)) * 4 * wo.z * cos_i);
  return color_ * (density * unmasked * std::min(bound_out_, bound(cos_i)));
}

Sheen Sheen::turned(float cos_o) const { return {color_, std::sqrt(alpha_), cos_o, beyond_}; }

Sheen8::Sheen8(const Sheen& sheen, const Vec3& wo)
    : wo_(wo), scale_(sheen.color_ * (density_scale(sheen.alpha_) / (4 * wo.z))), exponent_(0.5f / sheen.alpha_),
      masking_(sheen.masking_), lambda_out_(sheen.lambda_out_), bound_out_(sheen.bound_out_),
      through_out_(sheen.through_out_), through_(tables().reflected.row(sheen.alpha_)) {
  for (float& value : through_.value) value = 1 - max_component(sheen.color_) * value;
  if (sheen.alpha_ < kBoundedAlpha) bounds_ = tables().bound.row(sheen.alpha_);
}

Float8 Sheen8::lambda(const Float8& cosine) const {
  constexpr float kLog2E = std::numbers::log2e_v<float>;
  const SheenMasking& m = masking_;
  const Mask8 low = cosine < kMiddle;
  const Float8 x = low ? cosine : 1 - cosine;
  const Float8 exponent = m.a / (1 + m.b * exp2_8(m.c * log2_8(max8(x, Float8{} + kMinCos)))) + m.d * x + m.e;
  return exp2_8(kLog2E * (low ? exponent : 2 * m.exponent(kMiddle) - exponent));
}

Vec3x8 Sheen8::eval(const Vec3x8& wi) const {
  const Float8 cos_i = min8(max8(wi.z, Float8{} + kMinCos), Float8{} + 1);
  const Float8 density = power_of_sine(wi + wo_, exponent_);
  const Float8 f = density / ((1 + lambda_out_ + lambda(cos_i)) * cos_i);
  return scale_ * (bounds_ ? f * min8((*bounds_)(cos_i), Float8{} + bound_out_) : f);
}

}  // namespace photond
