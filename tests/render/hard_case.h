#pragma once

#include <deque>
#include <string>
#include <vector>

#include "tests/support/statistics.h"

namespace photond::test {

/// What a quantity may differ by from its expected value beside the noise. A slack has its reason in a comment
/// beside its use.
struct Tolerance {
  double relative = 0;  ///< of the expected value
  double absolute = 0;
  double precision = 0.01;  ///< largest standard error, relative (to `absolute` where 0 is expected): a mean
                            ///< noisier than that proves nothing and fails
};

/// One number of a hard case: expected once, measured by several methods and seeds.
class Quantity {
 public:
  /// A quantity that equals `expected`, or, with `bound`, does not exceed it.
  Quantity(std::string what, double expected, bool bound, const Tolerance& tolerance);

  /// Judges a mean with its noise: kSigmas normal-equivalent standard errors beyond the tolerance. `run` says
  /// which method and seed.
  void add(const std::string& run, const Sample& sample);
  /// Judges a value without noise.
  void add(const std::string& run, double value);

  /// This quantity's cells of the table, after those for number and title.
  std::string cells() const;

 private:
  double excess(double value) const;
  void note(const std::string& run, double value, double share, bool pass);

  std::string what_;
  double expected_;
  bool bound_;
  Tolerance tolerance_;
  int runs_ = 0;
  bool pass_ = true;
  bool noisy_ = false;
  double low_ = 0;
  double high_ = 0;
  double error_ = 0;  // largest standard error
  double worst_ = 0;  // largest deviation: in sigmas where noisy, as a share of the tolerance otherwise
};

/// A hard case while it runs. Its quantities are judged by GoogleTest and entered in the table that ./run
/// hardcases writes to tests/README.md: both come from the same measurement.
class HardCase {
 public:
  HardCase(int number, std::string title) : number_(number), title_(std::move(title)) {}
  ~HardCase();
  HardCase(const HardCase&) = delete;
  HardCase& operator=(const HardCase&) = delete;

  Quantity& equals(const std::string& what, double expected, const Tolerance& tolerance = {}) {
    return quantities_.emplace_back(what, expected, false, tolerance);
  }
  Quantity& at_most(const std::string& what, double bound, const Tolerance& tolerance = {}) {
    return quantities_.emplace_back(what, bound, true, tolerance);
  }

 private:
  int number_;
  std::string title_;
  std::deque<Quantity> quantities_;
};

}  // namespace photond::test
