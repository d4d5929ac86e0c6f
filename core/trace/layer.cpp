#include "core/trace/layer.h"

#include <array>
#include <cmath>

namespace photond {

namespace {

constexpr int kSize = 32;  // nodes per axis

// The split of the layer's albedo into the parts that f0 and f90 scale, by stratified sampling of visible normals.
LayerAlbedo integrate(float cos_o, float alpha) {
  constexpr int kSide = 16;
  const Vec3 wo{std::sqrt(std::max(0.0f, 1 - cos_o * cos_o)), 0, cos_o};
  const Ggx facets(alpha);
  double a = 0;
  double b = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 u{(static_cast<float>(i % kSide) + 0.5f) / kSide, (static_cast<float>(i / kSide) + 0.5f) / kSide};
    const Vec3 h = facets.sample_visible(wo, u);
    const Vec3 wi = 2 * glm::dot(wo, h) * h - wo;
    if (wi.z <= 0) continue;
    const double weight = facets.g2(wo, wi) / facets.g1(wo);
    const double schlick = schlick_weight(glm::dot(wo, h));
    a += weight * (1 - schlick);
    b += weight * schlick;
  }
  constexpr double kCount = kSide * kSide;
  return {static_cast<float>(a / kCount), static_cast<float>(b / kCount)};
}

// Nodes lie at √α = i/(n−1) and at cos = (j/(n−1))², denser at grazing angles where the albedo varies fastest.
struct Table {
  std::array<std::array<LayerAlbedo, kSize>, kSize> directional;
  std::array<LayerAlbedo, kSize> average;

  Table() {
    for (int i = 0; i < kSize; ++i) {
      const float root = static_cast<float>(i) / (kSize - 1);
      const float alpha = std::max(root * root, kSmoothAlpha);
      for (int j = 0; j < kSize; ++j) {
        const float s = static_cast<float>(j) / (kSize - 1);
        directional[i][j] = integrate(std::max(s * s, 1e-4f), alpha);
      }
      average[i] = mean(directional[i]);
    }
  }

  // 2∫E cos d cos over the interpolated row, so that the layering conserves energy for the values in use.
  static LayerAlbedo mean(const std::array<LayerAlbedo, kSize>& row) {
    constexpr int kSteps = 1024;
    double a = 0;
    double b = 0;
    for (int k = 0; k < kSteps; ++k) {
      const float c = (static_cast<float>(k) + 0.5f) / kSteps;
      const LayerAlbedo e = at(row, c);
      a += 2.0 * c * e.a / kSteps;
      b += 2.0 * c * e.b / kSteps;
    }
    return {static_cast<float>(a), static_cast<float>(b)};
  }

  static LayerAlbedo lerp(const LayerAlbedo& x, const LayerAlbedo& y, float t) {
    return {x.a + t * (y.a - x.a), x.b + t * (y.b - x.b)};
  }

  static LayerAlbedo at(const std::array<LayerAlbedo, kSize>& row, float cos_o) {
    const float s = std::sqrt(std::clamp(cos_o, 0.0f, 1.0f)) * (kSize - 1);
    const int j = std::min(static_cast<int>(s), kSize - 2);
    return lerp(row[j], row[j + 1], s - static_cast<float>(j));
  }
};

const Table& table() {
  static const Table instance;
  return instance;
}

float alpha_position(float alpha, int& cell) {
  const float s = std::sqrt(std::clamp(alpha, 0.0f, 1.0f)) * (kSize - 1);
  cell = std::min(static_cast<int>(s), kSize - 2);
  return s - static_cast<float>(cell);
}

}  // namespace

LayerAlbedo layer_albedo(float cos_o, float alpha) {
  if (alpha < kSmoothAlpha) {
    const float schlick = schlick_weight(cos_o);
    return {1 - schlick, schlick};
  }
  int i = 0;
  const float t = alpha_position(alpha, i);
  return Table::lerp(Table::at(table().directional[i], cos_o), Table::at(table().directional[i + 1], cos_o), t);
}

LayerAlbedo layer_albedo_average(float alpha) {
  // 2∫(1 − c)^5 c dc = 1/21.
  if (alpha < kSmoothAlpha) return {20.0f / 21, 1.0f / 21};
  int i = 0;
  const float t = alpha_position(alpha, i);
  return Table::lerp(table().average[i], table().average[i + 1], t);
}

float Layer::through(const Vec3& w) const {
  if (!reflects()) return 1;
  const LayerAlbedo e = layer_albedo(w.z, facets.seen_from(w));
  return std::max(0.0f, 1 - (f0 * e.a + f90 * e.b));
}

LayerTransmission::LayerTransmission(const Layer& layer) : layer_(layer), smooth_(layer.facets.least() < kSmoothAlpha) {
  static_assert(CosineNodes::kCount == kSize);
  if (smooth_ || !isotropic()) return;
  int i = 0;
  const float t = alpha_position(layer.facets.least(), i);
  const auto &low = table().directional[i], &high = table().directional[i + 1];
  for (int j = 0; j < kSize; ++j) {
    const LayerAlbedo e = Table::lerp(low[j], high[j], t);
    nodes_.value[j] = std::max(0.0f, 1 - (layer.f0 * e.a + layer.f90 * e.b));
  }
}

Float8 LayerTransmission::operator()(const Float8& cosine) const {
  if (smooth_) {
    const Float8 c = min8(max8(cosine, Float8{}), Float8{} + 1);
    const Float8 m = 1 - c, m_sq = m * m, schlick = m_sq * m_sq * m;
    return max8(1 - (layer_.f0 * (1 - schlick) + layer_.f90 * schlick), Float8{});
  }
  return nodes_(cosine);
}

Float8 LayerTransmission::operator()(const Vec3x8& w) const {
  if (isotropic()) return (*this)(w.z);
  Float8 through;
  for (int k = 0; k < 8; ++k) through[k] = layer_.through({w.x[k], w.y[k], w.z[k]});
  return through;
}

}  // namespace photond
