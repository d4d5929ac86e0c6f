#pragma once

#include <cmath>
#include <cstdint>

namespace photond {

/// Share of the photons kept by the shrinking radius [Knaus and Zwicker 2011]: variance n^−α, bias n^(α−1).
/// Close to 1: the radii of one pass span a factor of 16 already, and what is added of each decides (reconstruct).
inline constexpr double kRadiusAlpha = 0.9;

/// r²_pass/r²_0 of independent progressive passes, pass = 0, 1, …: Γ(i+α)/(Γ(1+α)Γ(i+1)) with i = pass + 1
/// [Knaus and Zwicker 2011, eq. 14 in closed form].
inline double radius_sq_factor(std::uint32_t pass) {
  const double i = static_cast<double>(pass) + 1;
  // A double's lgamma loses eight digits at i = 10^8, still more than the float radius keeps.
  int sign = 1;
  const double a = lgamma_r(i + kRadiusAlpha, &sign);
  const double b = lgamma_r(1 + kRadiusAlpha, &sign);
  const double c = lgamma_r(i + 1, &sign);
  return std::exp(a - b - c);
}

}  // namespace photond
