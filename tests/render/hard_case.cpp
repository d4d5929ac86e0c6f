#include "tests/render/hard_case.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace photond::test {

namespace {

// Float estimates add up with a few parts in a million of rounding.
constexpr double kRounding = 3e-6;

struct Row {
  int number;
  std::string text;
};

std::vector<Row>& rows() {
  static std::vector<Row> all;
  return all;
}

// Writes the table where the environment names a file for it: only ./run hardcases does.
class TableWriter : public testing::Environment {
 public:
  void TearDown() override {
    const char* path = std::getenv("PHOTOND_HARD_CASES");
    if (path == nullptr) return;
    std::stable_sort(rows().begin(), rows().end(),
                     [](const Row& a, const Row& b) { return a.number < b.number; });
    std::ofstream out(path);
    out << "| # | case | quantity | expected | measured | deviation of tolerance | verdict |\n"
        << "|---|---|---|---|---|---|---|\n";
    for (const Row& row : rows()) out << row.text;
    ASSERT_TRUE(out.flush()) << path;
  }
};

[[maybe_unused]] testing::Environment* const kTable = testing::AddGlobalTestEnvironment(new TableWriter);

std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

}  // namespace

Quantity::Quantity(std::string what, double expected, bool bound, const Tolerance& tolerance)
    : what_(std::move(what)), expected_(expected), bound_(bound), tolerance_(tolerance) {}

// How far `value` is beyond what the tolerance allows.
double Quantity::excess(double value) const {
  const double deviation = bound_ ? value - expected_ : std::abs(value - expected_);
  return std::max(0.0, deviation - tolerance_.absolute - tolerance_.relative * std::abs(expected_));
}

void Quantity::add(const std::string& run, const Sample& sample) {
  noisy_ = true;
  const double error = sample.standard_error();
  error_ = std::max(error_, error);
  const double beyond = std::max(0.0, excess(sample.mean) - kRounding * std::abs(expected_));
  const double sigmas =
      beyond == 0 ? 0 : normal_equivalent(beyond / error, static_cast<double>(sample.count) - 1);
  const double scale = expected_ != 0 ? std::abs(expected_) : tolerance_.absolute;
  const bool precise = bound_ || error <= tolerance_.precision * scale;
  EXPECT_TRUE(precise) << what_ << ", " << run << ": " << sample.mean << " ± " << error << " is too noisy";
  note(run, sample.mean, sigmas, precise && sigmas <= kSigmas);
}

void Quantity::add(const std::string& run, double value) {
  const double allowed = tolerance_.absolute + tolerance_.relative * std::abs(expected_);
  const double deviation = std::max(0.0, bound_ ? value - expected_ : std::abs(value - expected_));
  note(run, value, deviation == 0 ? 0 : deviation / allowed, excess(value) == 0);  // NaN fails
}

void Quantity::note(const std::string& run, double value, double share, bool pass) {
  pass = pass && std::isfinite(value);
  EXPECT_TRUE(pass) << what_ << ", " << run << ": " << value << " ± " << error_ << ", expected "
                    << (bound_ ? "at most " : "") << expected_;
  pass_ = pass_ && pass;
  low_ = runs_ == 0 ? value : std::min(low_, value);
  high_ = runs_ == 0 ? value : std::max(high_, value);
  worst_ = std::max(worst_, share);
  ++runs_;
}

std::string Quantity::cells() const {
  const double slack = tolerance_.absolute + tolerance_.relative * std::abs(expected_);
  std::string measured = text("%.6g", low_);
  if (high_ != low_) measured += text(" … %.6g", high_);
  if (noisy_) measured += text(" ± %.2g", error_);
  if (runs_ > 1) measured += ", " + std::to_string(runs_) + " runs";
  std::string deviation;
  if (noisy_) {
    deviation = text("%.1f", worst_) + text(" of %.1f σ", kSigmas);
    if (slack > 0) deviation += text(" beyond %.2g", slack);
  } else {
    deviation = slack == 0 ? "exact" : text("%.2g of ", worst_ * slack) + text("%.2g", slack);
    if (bound_ && slack == 0) deviation = "bound";
  }
  return what_ + " | " + (bound_ ? "≤ " : "") + text("%.6g", expected_) + " | " + measured + " | " + deviation +
         " | " + (pass_ && runs_ > 0 ? "holds" : "**fails**");
}

HardCase::~HardCase() {
  for (const Quantity& quantity : quantities_) {
    rows().push_back(
        {number_, "| " + std::to_string(number_) + " | " + title_ + " | " + quantity.cells() + " |\n"});
  }
}

}  // namespace photond::test
