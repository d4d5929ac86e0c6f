#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/math/rng.h"

namespace photond::test {

/// Significance of one statistical check: α = 0.01 for a whole run of up to 200 checks (Šidák). Seeds are fixed, so
/// a check that passes keeps passing.
inline constexpr double kSignificance = 5e-5;

/// Probability of a χ² at least this large with `degrees` of freedom [Wilson and Hilferty 1931], good to a percent
/// from 20 degrees on.
double chi2_tail(double chi2, double degrees);

/// p-value of Pearson's test; cells expecting fewer than five are pooled.
double chi2_test(const std::vector<double>& observed, const std::vector<double>& expected);

/// Draws directions and compares their histogram over the sphere with the integral of `pdf` over its cells. `sample`
/// may return the zero vector for "no direction"; `pdf` then integrates to less than one. `fine` is the number of
/// quadrature points per cell and axis: more where the density jumps. Returns the p-value.
double chi2_sphere(const std::function<Vec3(Rng&)>& sample, const std::function<double(const Vec3&)>& pdf,
                   int fine = 20);

/// Mean and its standard error of repeated draws.
struct Sample {
  std::uint64_t count = 0;
  double mean = 0;
  double m2 = 0;
  void add(double x);
  double standard_error() const;
};

/// Draws `count` values.
Sample draw(std::uint64_t count, const std::function<double(Rng&)>& value, std::uint64_t seed = 1);

/// kSignificance in standard deviations of a normal distribution, both sides together.
inline constexpr double kSigmas = 4.1;

/// The normal deviate as improbable as Student's `t` with `degrees` of freedom [Wallace 1959]: the fewer the draws,
/// the less their spread tells of the true one.
double normal_equivalent(double t, double degrees);

/// Whether the mean agrees with `expected` at kSignificance (kSigmas standard errors).
bool agrees(const Sample& sample, double expected);

}  // namespace photond::test
