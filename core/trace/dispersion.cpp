// KHR_materials_dispersion. Wyman, Sloan and Shirley 2013: the observer of CIE 1931 as a sum of Gaussians.
#include "core/trace/dispersion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/rng.h"

namespace photond {

namespace {

constexpr int kFirst = 380, kLast = 720;        // nanometres
constexpr std::size_t kQuantiles = 128;

double lobe(double wavelength, double height, double middle, double below, double above) {
  const double t = (wavelength - middle) / (wavelength < middle ? below : above);
  return height * std::exp(-0.5 * t * t);
}

// What an even spectrum adds to a channel of linear sRGB there; nothing where that is negative.
double response(int channel, double wavelength) {
  const double x = lobe(wavelength, 1.056, 599.8, 37.9, 31.0) + lobe(wavelength, 0.362, 442.0, 16.0, 26.7) +
                   lobe(wavelength, -0.065, 501.1, 20.4, 26.2);
  const double y = lobe(wavelength, 0.821, 568.8, 46.9, 40.5) + lobe(wavelength, 0.286, 530.9, 16.3, 31.1);
  const double z = lobe(wavelength, 1.217, 437.0, 11.8, 36.0) + lobe(wavelength, 0.681, 459.0, 26.0, 13.8);
  static constexpr double kToRgb[3][3] = {
      {3.2406, -1.5372, -0.4986}, {-0.9689, 1.8758, 0.0415}, {0.0557, -0.2040, 1.0570}};
  return std::max(0.0, kToRgb[channel][0] * x + kToRgb[channel][1] * y + kToRgb[channel][2] * z);
}

using Quantiles = std::array<float, kQuantiles + 1>;

// Wavelengths below which i/kQuantiles of the channel's response lie.
Quantiles quantiles(int channel) {
  double total = 0;
  for (int w = kFirst; w < kLast; ++w) total += response(channel, w + 0.5);
  Quantiles found;
  double below = 0;
  std::size_t i = 0;
  for (int w = kFirst; w < kLast; ++w) {
    const double share = response(channel, w + 0.5) / total;
    for (; i < kQuantiles && static_cast<double>(i) / kQuantiles < below + share; ++i) {
      found[i] = static_cast<float>(w + (static_cast<double>(i) / kQuantiles - below) / share);
    }
    if (share > 0) found[kQuantiles] = static_cast<float>(w + 1);
    below += share;
  }
  return found;
}

float quantile(const Quantiles& table, double u) {
  const double place = u * kQuantiles;
  const auto i = std::min(static_cast<std::size_t>(place), kQuantiles - 1);
  return std::lerp(table[i], table[i + 1], static_cast<float>(place - static_cast<double>(i)));
}

}  // namespace

Vec3 wavelengths_of_pass(std::uint64_t seed, std::uint32_t pass) {
  static const std::array<Quantiles, 3> kTables = {quantiles(0), quantiles(1), quantiles(2)};
  // Multiples of the golden ratio are spread evenly, whatever they begin with.
  const std::uint64_t turn = mix64(seed + 0x3c6ef372fe94f82bULL) + 0x9e3779b97f4a7c15ULL * pass;
  const double u = static_cast<double>(turn >> 11) * 0x1p-53;
  return {quantile(kTables[0], u), quantile(kTables[1], u), quantile(kTables[2], u)};
}

float index_at(const Material& m, float wavelength) {
  // Material::dispersion is 20 over Abbe's number, which lies between the lines F (486.13 nm) and C (656.27 nm).
  constexpr double kSodium = 587.56, kBlue = 486.13, kRed = 656.27;
  constexpr double kScale = 1 / (1 / (kBlue * kBlue) - 1 / (kRed * kRed));
  const double w = wavelength;
  const double change = kScale * (1 / (w * w) - 1 / (kSodium * kSodium)) * static_cast<double>(m.dispersion) / 20;
  return static_cast<float>(std::max(1.0, static_cast<double>(m.ior) + (static_cast<double>(m.ior) - 1) * change));
}

void disperse(SurfacePoint& surface, Rgb& light, const Vec3& wavelengths, float u) {
  const float sum = light.x + light.y + light.z;
  const float place = u * sum;
  int channel = place < light.x ? 0 : place < light.x + light.y ? 1 : 2;
  while (channel > 0 && light[channel] == 0) --channel;   // which rounding alone can find
  light = Rgb(0);
  light[channel] = sum;
  surface.ior = index_at(*surface.material, wavelengths[channel]);
}

}  // namespace photond
