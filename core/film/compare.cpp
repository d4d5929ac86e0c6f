#include "core/film/compare.h"

#include <algorithm>
#include <cmath>

#include "core/film/relative_floor.h"

namespace photond {
namespace {

constexpr double kTrimmedShare = 0.001;  // of the pixels
constexpr int kBlock = 8;
constexpr double kBrightShare = 0.01;  // of the mean of the picture

Status check_comparable(const Image& a, const Image& reference) {
  if (a.width != reference.width || a.height != reference.height) {
    return invalid_input("the pictures have different sizes");
  }
  if (a.pixels.empty()) return invalid_input("the pictures are empty");
  const auto finite = [](const Image& image) {
    return std::all_of(image.pixels.begin(), image.pixels.end(), [](const Rgb& p) { return is_finite(p); });
  };
  if (!finite(a) || !finite(reference)) return invalid_input("a picture contains a value that is not finite");
  return Done{};
}

/// Mean over the channels of (a − r)²/(r² + floor).
double relative_error(const Rgb& a, const Rgb& r, double floor) {
  const glm::dvec3 difference = glm::dvec3(a) - glm::dvec3(r);
  const glm::dvec3 ratio = difference * difference / (glm::dvec3(r) * glm::dvec3(r) + floor);
  return (ratio.x + ratio.y + ratio.z) / 3;
}

glm::dvec3 mean_color(const Image& image) {
  glm::dvec3 sum(0);
  for (const Rgb& pixel : image.pixels) sum += glm::dvec3(pixel);
  return sum / static_cast<double>(image.pixels.size());
}

/// Mean luminance of the block whose corner is (x0, y0); blocks at the right and lower edge may be smaller.
double block_mean(const Image& image, int x0, int y0) {
  double sum = 0;
  const int x1 = std::min(x0 + kBlock, image.width), y1 = std::min(y0 + kBlock, image.height);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) sum += luminance(image.at(x, y));
  }
  return sum / ((x1 - x0) * (y1 - y0));
}

/// Relative deviations of all bright blocks, in increasing order.
std::vector<double> block_deviations(const Image& a, const Image& reference) {
  const glm::dvec3 mean = mean_color(reference);
  const double threshold = kBrightShare * (0.2126 * mean.x + 0.7152 * mean.y + 0.0722 * mean.z);
  std::vector<double> out;
  for (int y = 0; y < reference.height; y += kBlock) {
    for (int x = 0; x < reference.width; x += kBlock) {
      const double r = block_mean(reference, x, y);
      if (r > threshold) out.push_back(std::abs(block_mean(a, x, y) - r) / r);
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

double mean_without_worst(std::vector<double> errors) {
  const auto dropped = static_cast<std::size_t>(std::ceil(kTrimmedShare * static_cast<double>(errors.size())));
  if (dropped >= errors.size()) return 0;
  std::sort(errors.begin(), errors.end());
  errors.resize(errors.size() - dropped);
  double sum = 0;
  for (double error : errors) sum += error;
  return sum / static_cast<double>(errors.size());
}

}  // namespace

Result<Comparison> compare_images(const Image& a, const Image& reference) {
  if (Status status = check_comparable(a, reference); !status) return status.error();
  Comparison out;
  const glm::dvec3 mean_a = mean_color(a), mean_r = mean_color(reference);
  const double floor = relative_floor((mean_r.x + mean_r.y + mean_r.z) / 3);
  std::vector<double> errors;
  errors.reserve(a.pixels.size());
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const glm::dvec3 difference = glm::dvec3(a.pixels[i]) - glm::dvec3(reference.pixels[i]);
    out.mse += glm::dot(difference, difference) / 3;
    errors.push_back(relative_error(a.pixels[i], reference.pixels[i], floor));
    out.rel_mse += errors.back();
  }
  const auto pixels = static_cast<double>(a.pixels.size());
  out.mse /= pixels;
  out.rel_mse /= pixels;
  out.rel_mse_trimmed = mean_without_worst(std::move(errors));
  for (int c = 0; c < 3; ++c) out.mean_ratio[c] = mean_a[c] == mean_r[c] ? 1 : mean_a[c] / mean_r[c];
  const std::vector<double> deviations = block_deviations(a, reference);
  if (!deviations.empty()) {
    out.max_block_deviation = deviations.back();
    out.median_block_deviation = deviations[deviations.size() / 2];
  }
  return out;
}

}  // namespace photond
