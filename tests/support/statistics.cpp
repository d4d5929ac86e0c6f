#include "tests/support/statistics.h"

#include <algorithm>

namespace photond::test {

double chi2_tail(double chi2, double degrees) {
  const double v = 2 / (9 * degrees);
  const double z = (std::cbrt(chi2 / degrees) - (1 - v)) / std::sqrt(v);
  return 0.5 * std::erfc(z / std::sqrt(2.0));
}

double chi2_test(const std::vector<double>& observed, const std::vector<double>& expected) {
  double chi2 = 0;
  double pooled_observed = 0;
  double pooled_expected = 0;
  int cells = 0;
  const auto add = [&](double o, double e) {
    chi2 += (o - e) * (o - e) / e;
    ++cells;
  };
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (expected[i] >= 5) {
      add(observed[i], expected[i]);
    } else {
      pooled_observed += observed[i];
      pooled_expected += expected[i];
    }
  }
  if (pooled_expected >= 5) {
    add(pooled_observed, pooled_expected);
  } else if (pooled_observed > 40) {
    return 0;  // samples where there should be none
  }
  return cells < 2 ? 0 : chi2_tail(chi2, cells - 1);
}

double chi2_sphere(const std::function<Vec3(Rng&)>& sample, const std::function<double(const Vec3&)>& pdf,
                   int fine) {
  constexpr int kTheta = 24;  // uniform in θ: densities are smooth in it, unlike in z at the poles
  constexpr int kPhi = 48;
  constexpr std::uint64_t kSamples = 200'000;
  std::vector<double> observed(kTheta * kPhi + 1, 0);
  std::vector<double> expected(kTheta * kPhi + 1, 0);
  Rng rng(1, RngPurpose::pilot, 7, 7);
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const Vec3 w = sample(rng);
    if (w == Vec3(0)) {
      ++observed.back();
      continue;
    }
    const float theta = std::atan2(std::hypot(w.x, w.y), w.z);
    const int row = std::clamp(static_cast<int>(theta / kPi * kTheta), 0, kTheta - 1);
    const float turn = std::atan2(w.y, w.x) / (2 * kPi);
    const int phi = std::clamp(static_cast<int>((turn < 0 ? turn + 1 : turn) * kPhi), 0, kPhi - 1);
    ++observed[static_cast<std::size_t>(row * kPhi + phi)];
  }
  double total = 0;
  for (int cell = 0; cell < kTheta * kPhi; ++cell) {
    double sum = 0;
    for (int k = 0; k < fine * fine; ++k) {
      const double theta = kPi * ((cell / kPhi) + (k / fine + 0.5) / fine) / kTheta;
      const double phi = 2 * kPi * ((cell % kPhi) + (k % fine + 0.5) / fine) / kPhi;
      const double sine = std::sin(theta);
      sum += pdf(Vec3(sine * std::cos(phi), sine * std::sin(phi), std::cos(theta))) * sine;
    }
    const double probability = sum / (fine * fine) * 2 * kPi * kPi / (kTheta * kPhi);
    expected[static_cast<std::size_t>(cell)] = probability * kSamples;
    total += probability;
  }
  expected.back() = std::max(0.0, 1 - total) * kSamples;
  return chi2_test(observed, expected);
}

void Sample::add(double x) {
  ++count;
  const double delta = x - mean;
  mean += delta / static_cast<double>(count);
  m2 += delta * (x - mean);
}

double Sample::standard_error() const {
  const auto n = static_cast<double>(count);
  return std::sqrt(m2 / (n * (n - 1)));
}

Sample draw(std::uint64_t count, const std::function<double(Rng&)>& value, std::uint64_t seed) {
  Sample sample;
  for (std::uint64_t i = 0; i < count; ++i) {
    Rng rng(seed, RngPurpose::pilot, 3, i);
    sample.add(value(rng));
  }
  return sample;
}

double normal_equivalent(double t, double degrees) {
  return (8 * degrees + 1) / (8 * degrees + 3) * std::sqrt(degrees * std::log1p(t * t / degrees));
}

bool agrees(const Sample& sample, double expected) {
  // Rounding of float estimates adds up to a few parts in a million.
  return std::abs(sample.mean - expected) <= kSigmas * sample.standard_error() + 3e-6 * std::abs(expected);
}

}  // namespace photond::test
