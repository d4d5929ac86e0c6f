#include "core/scene/environment.h"

#include <cmath>

#include "core/film/decode_radiance.h"
#include "core/math/warp.h"

namespace photond {

namespace {

// Share of the choices that ignores radiance: shade that only a dim sky lights still gets its samples.
constexpr double kFloor = 0.05;

double mean_of(const Rgb& c) { return (static_cast<double>(c.x) + c.y + c.z) / 3; }

Vec3 turned(const Vec3& w, float angle) {
  if (angle == 0) return w;
  const float c = std::cos(angle), s = std::sin(angle);
  return {c * w.x + s * w.z, w.y, c * w.z - s * w.x};
}

Digest digest_of(int width, int height, const std::vector<Rgb>& pixels) {
  Hasher hasher;
  hasher.update("photond environment 1");
  hasher.update_value(width);
  hasher.update_value(height);
  hasher.update(std::as_bytes(std::span(pixels)));
  return hasher.finish();
}

// Clamps what is negative; an error where a value is none.
Result<std::uint64_t> clean(Image& image) {
  // Larger values overflow once they are multiplied by areas and summed.
  constexpr float kLargest = 1e30f;
  std::uint64_t negative = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    Rgb& pixel = image.pixels[i];
    for (int c = 0; c < 3; ++c) {
      if (!(std::abs(pixel[c]) <= kLargest)) {
        const auto width = static_cast<std::size_t>(image.width);
        return invalid_input("pixel (" + std::to_string(i % width) + ", " + std::to_string(i / width) +
                             ") is not a number of at most 1e30");
      }
      if (pixel[c] < 0) ++negative;
      pixel[c] = std::max(pixel[c], 0.0f);
    }
  }
  return negative;
}

}  // namespace

EnvironmentMap::EnvironmentMap(int width, int height, std::vector<Rgb> pixels)
    : width_(width), height_(height), pixels_(std::move(pixels)), digest_(digest_of(width, height, pixels_)) {
  const auto rows = static_cast<std::size_t>(height) + 1;
  for (std::size_t y = 0; y <= rows; ++y) {
    const double v = std::clamp((static_cast<double>(y) - 0.5) / height, 0.0, 1.0);
    cosines_.push_back(y == 0 ? 1 : y == rows ? -1 : std::cos(v * std::numbers::pi));
  }
  for (std::size_t y = 0; y < rows; ++y) {
    const double angle = 2 * std::numbers::pi / width * (cosines_[y] - cosines_[y + 1]);
    inverse_angles_.push_back(static_cast<float>(1 / angle));
  }
  make_distribution();
}

void EnvironmentMap::make_distribution() {
  const auto columns = static_cast<std::uint32_t>(width_);
  const auto rows = static_cast<std::uint32_t>(height_) + 1;
  std::vector<float> weights(std::size_t{columns} * rows);
  double power = 0, power_sq = 0;
  for (std::uint32_t y = 0; y < rows; ++y) {
    const double angle = 2 * std::numbers::pi / width_ * (cosines_[y] - cosines_[y + 1]);
    for (std::uint32_t x = 0; x < columns; ++x) {
      const double level = (mean_of(radiance(Cell{x, y, 0, 0})) + mean_of(radiance(Cell{x, y, 1, 0})) +
                            mean_of(radiance(Cell{x, y, 0, 1})) + mean_of(radiance(Cell{x, y, 1, 1}))) / 4;
      weights[std::size_t{y} * columns + x] = static_cast<float>(level);
      power += angle * level;
      power_sq += angle * level * level;
    }
  }
  mean_ = power / (4 * std::numbers::pi);
  if (!(mean_ > 0)) return;
  concentration_ = 4 * std::numbers::pi * power_sq / (power * power);
  for (std::uint32_t y = 0; y < rows; ++y) {
    const double share = (cosines_[y] - cosines_[y + 1]) / mean_;   // the scale does not matter
    for (std::uint32_t x = 0; x < columns; ++x) {
      float& weight = weights[std::size_t{y} * columns + x];
      if (weight > 0) weight = static_cast<float>(share * (weight + kFloor * mean_));
    }
  }
  distribution_ = GridDistribution(columns, rows, weights);
}

Rgb EnvironmentMap::texel(std::uint32_t x, std::uint32_t row_of_cells) const {
  const auto columns = static_cast<std::uint32_t>(width_);
  const auto y = static_cast<std::uint32_t>(std::clamp(static_cast<int>(row_of_cells) - 1, 0, height_ - 1));
  return pixels_[std::size_t{y} * columns + (x < columns ? x : x - columns)];
}

Rgb EnvironmentMap::radiance(const Cell& cell) const {
  const Rgb top = texel(cell.x, cell.y) * (1 - cell.s) + texel(cell.x + 1, cell.y) * cell.s;
  const Rgb bottom = texel(cell.x, cell.y + 1) * (1 - cell.s) + texel(cell.x + 1, cell.y + 1) * cell.s;
  return top * (1 - cell.t) + bottom * cell.t;
}

EnvironmentMap::Cell EnvironmentMap::cell_at(const Vec3& w) const {
  const float columns = static_cast<float>(width_), rows = static_cast<float>(height_);
  const float longitude = std::atan2(w.z, w.x) * (0.5f * kInvPi) + 0.5f;
  const float colatitude = std::atan2(std::hypot(w.x, w.z), w.y) * kInvPi;
  float x = longitude * columns - 0.5f;
  if (x < 0) x += columns;
  x = std::clamp(x, 0.0f, columns);
  const float y = std::clamp(colatitude * rows + 0.5f, 0.0f, rows + 0.5f);
  const auto i = std::min(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(width_) - 1);
  const auto j = std::min(static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(height_));
  return {i, j, x - static_cast<float>(i), y - static_cast<float>(j)};
}

Rgb EnvironmentMap::radiance(const Vec3& direction) const { return radiance(cell_at(direction)); }

float EnvironmentMap::pdf(const Vec3& direction) const {
  if (!(mean_ > 0)) return 0;
  const Cell cell = cell_at(direction);
  return distribution_.probability(cell.x, cell.y) * inverse_angles_[cell.y];
}

EnvironmentSample EnvironmentMap::sample(const Vec2& u) const {
  const GridDistribution::Place place = distribution_.sample(u);
  // Uniform in solid angle within the cell. In double: near a pole the cosine alone has too few digits.
  const double t = static_cast<double>(place.t);
  const double height = cosines_[place.y] * (1 - t) + cosines_[place.y + 1] * t;
  const auto radius = static_cast<float>(std::sqrt(std::max(0.0, (1 - height) * (1 + height))));
  const auto y = static_cast<float>(height);
  const float column = static_cast<float>(place.x) + 0.5f + place.s;
  const float longitude = (column / static_cast<float>(width_) - 0.5f) * (2 * kPi);
  const float row = std::atan2(radius, y) * kInvPi * static_cast<float>(height_) + 0.5f;
  // The cell that was drawn, not the one that rounding finds the direction in.
  const Cell cell{place.x, place.y, place.s, std::clamp(row - static_cast<float>(place.y), 0.0f, 1.0f)};
  return {{radius * std::cos(longitude), y, radius * std::sin(longitude)},
          radiance(cell),
          place.probability * inverse_angles_[place.y]};
}

Result<std::shared_ptr<const EnvironmentMap>> read_environment(std::span<const std::byte> bytes,
                                                               const EnvironmentLimits& limits) {
  Result<Image> image = decode_radiance(bytes, limits.max_side, limits.max_pixels);
  if (!image) return image.error();
  const Result<std::uint64_t> negative = clean(*image);
  if (!negative) return negative.error();
  auto map = std::make_shared<EnvironmentMap>(image->width, image->height, std::move(image->pixels));
  if (*negative > 0) {
    map->warnings.push_back("environment: " + std::to_string(*negative) + " negative values are taken as 0");
  }
  if (!(map->mean() > 0)) map->warnings.push_back("environment: the map is black");
  return std::shared_ptr<const EnvironmentMap>(std::move(map));
}

Rgb Environment::from(const Vec3& direction) const {
  return map == nullptr ? radiance : radiance * map->radiance(turned(direction, -rotation));
}

EnvironmentSample Environment::sample(const Vec2& u) const {
  if (map == nullptr) return {square_to_sphere(u), radiance, kSpherePdf};
  EnvironmentSample sample = map->sample(u);
  sample.wi = turned(sample.wi, rotation);
  sample.radiance *= radiance;
  return sample;
}

float Environment::pdf_w(const Vec3& direction) const {
  return map == nullptr ? kSpherePdf : map->pdf(turned(direction, -rotation));
}

double Environment::mean() const { return mean_of(radiance) * (map == nullptr ? 1 : map->mean()); }

}  // namespace photond
