#include "core/math/warp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/math/alias_table.h"
#include "core/math/frame.h"
#include "core/math/octahedral.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using test::chi2_sphere;
using test::chi2_test;
using test::kSignificance;

TEST(Warp, CosineHemisphereMatchesItsPdf) {
  EXPECT_GT(chi2_sphere([](Rng& rng) { return square_to_cosine_hemisphere(rng.next2()); },
                        [](const Vec3& w) { return square_to_cosine_hemisphere_pdf(w); }),
            kSignificance);
}

TEST(Warp, SphereIsUniform) {
  EXPECT_GT(chi2_sphere([](Rng& rng) { return square_to_sphere(rng.next2()); }, [](const Vec3&) { return kSpherePdf; }),
            kSignificance);
}

TEST(Warp, ConeIsUniformInside) {
  // On a cell boundary of the histogram in θ, so that the quadrature meets no edge.
  const float cos_max = std::cos(kPi / 4);
  EXPECT_GT(chi2_sphere([&](Rng& rng) { return square_to_cone(rng.next2(), 1 - cos_max); },
                        [&](const Vec3& w) { return w.z > cos_max ? square_to_cone_pdf(1 - cos_max) : 0; }),
            kSignificance);
}

// Counts of points over a grid of the square [−1, 1]²; expectation by area inside the shape.
double chi2_square(const std::function<Vec2(Rng&)>& sample, const std::function<bool(double, double)>& inside,
                   double area) {
  constexpr int kSide = 16;
  constexpr int kFine = 64;
  constexpr int kSamples = 100'000;
  std::vector<double> observed(kSide * kSide, 0);
  std::vector<double> expected(kSide * kSide, 0);
  Rng rng(3, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 p = sample(rng);
    const int x = std::clamp(static_cast<int>((p.x * 0.5f + 0.5f) * kSide), 0, kSide - 1);
    const int y = std::clamp(static_cast<int>((p.y * 0.5f + 0.5f) * kSide), 0, kSide - 1);
    ++observed[static_cast<std::size_t>(y * kSide + x)];
  }
  const double step = 2.0 / (kSide * kFine);
  for (int y = 0; y < kSide * kFine; ++y) {
    for (int x = 0; x < kSide * kFine; ++x) {
      if (!inside(-1 + (x + 0.5) * step, -1 + (y + 0.5) * step)) continue;
      expected[static_cast<std::size_t>(y / kFine * kSide + x / kFine)] += kSamples * step * step / area;
    }
  }
  return chi2_test(observed, expected);
}

TEST(Warp, DiskIsUniform) {
  EXPECT_GT(chi2_square([](Rng& rng) { return square_to_disk(rng.next2()); },
                        [](double x, double y) { return x * x + y * y < 1; }, kPi),
            kSignificance);
}

TEST(Warp, ShiftsHitEveryRandomNumberOnce) {
  constexpr std::uint32_t kNumbers = 1 << 24;
  for (const float shift : {0.25f, 0.5f, 0.75f}) {
    std::vector<bool> hit(kNumbers, false);
    for (std::uint32_t i = 0; i < kNumbers; ++i) {
      const float u = shifted(Vec3(static_cast<float>(i) * 0x1p-24f), Vec3(shift)).x * 0x1p24f;
      ASSERT_EQ(u, std::floor(u));
      hit[static_cast<std::uint32_t>(u)] = true;
    }
    EXPECT_EQ(std::count(hit.begin(), hit.end(), true), kNumbers) << shift;
  }
}

TEST(Warp, DiskToSquareIsTheInverse) {
  Rng rng(1, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 10'000; ++i) {
    const Vec2 u = rng.next2();
    EXPECT_LT(glm::distance(disk_to_square(square_to_disk(u)), u), 1e-6f);
  }
  EXPECT_EQ(disk_to_square(Vec2(0)), Vec2(0.5f));
}

// What MarkedSquare counts on.
TEST(Warp, NeighboursOnTheDiskAreNeighboursInTheSquare) {
  Rng rng(2, RngPurpose::pilot, 0, 0);
  float most = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Vec2 a = square_to_disk(rng.next2()), b = a + 0.01f * (2.0f * rng.next2() - 1.0f);
    if (glm::dot(b, b) <= 1) most = std::max(most, glm::distance(disk_to_square(a), disk_to_square(b)) / glm::distance(a, b));
  }
  EXPECT_LT(most, 0.885f);
  EXPECT_GT(most, 0.85f);
}

TEST(Warp, TriangleIsUniform) {
  EXPECT_GT(chi2_square([](Rng& rng) { return square_to_triangle(rng.next2()); },
                        [](double x, double y) { return x > 0 && y > 0 && x + y < 1; }, 0.5),
            kSignificance);
}

// By all numbers that there are.
void expect_drawn_as_told(const std::vector<double>& weights) {
  const AliasTable table(weights);
  constexpr std::uint32_t kNumbers = 1 << 24;
  std::vector<std::uint32_t> drawn(weights.size(), 0);
  for (std::uint32_t i = 0; i < kNumbers; ++i) {
    const std::uint32_t index = table.sample(static_cast<float>(i) * 0x1p-24f);
    ASSERT_LT(index, weights.size());
    ++drawn[index];
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const auto n = static_cast<double>(weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    ASSERT_EQ(static_cast<double>(table.pdf(i)), static_cast<float>(drawn[i] * 0x1p-24)) << i;
    ASSERT_EQ(table.pdf(i) > 0, weights[i] > 0) << i;
    ASSERT_NEAR(static_cast<double>(table.pdf(i)), weights[i] / sum, weights[i] > sum / n ? n * 0x1p-24 : 0x1p-24) << i;
  }
}

TEST(AliasTable, DrawsItsProbabilities) { expect_drawn_as_told({1, 0, 3, 0.25, 10, 5e-3, 2}); }

TEST(AliasTable, DrawsOneOfOne) { expect_drawn_as_told({3}); }

// So many that a number has few steps for each: one that shines and others that hardly do.
TEST(AliasTable, DrawsOneOfVeryMany) {
  std::vector<double> weights(300'000, 0.05 / 300'000);
  weights[77] = 0.95;
  expect_drawn_as_told(weights);
}

TEST(Rng, IsUniformAndItsStreamsDiffer) {
  std::vector<double> observed(256, 0);
  std::vector<double> first(256, 0);
  Rng rng(1, RngPurpose::camera, 0, 0);
  for (int i = 0; i < 256'000; ++i) ++observed[static_cast<std::size_t>(rng.next() * 256)];
  // The first numbers of neighbouring streams, as neighbouring pixels use them.
  for (std::uint64_t i = 0; i < 256'000; ++i) {
    Rng stream(1, RngPurpose::camera, 0, i);
    ++first[static_cast<std::size_t>(stream.next() * 256)];
  }
  const std::vector<double> expected(256, 1000);
  EXPECT_GT(chi2_test(observed, expected), kSignificance);
  EXPECT_GT(chi2_test(first, expected), kSignificance);
}

TEST(Rng, PairsOfNeighbouringStreamsAreIndependent) {
  std::vector<double> observed(32 * 32, 0);
  for (std::uint64_t i = 0; i < 512'000; ++i) {
    Rng a(9, RngPurpose::photon, 5, i);
    Rng b(9, RngPurpose::photon, 5, i + 1);
    ++observed[static_cast<std::size_t>(a.next() * 32) * 32 + static_cast<std::size_t>(b.next() * 32)];
  }
  EXPECT_GT(chi2_test(observed, std::vector<double>(32 * 32, 500)), kSignificance);
}

TEST(Frame, IsOrthonormalForEveryNormal) {
  Rng rng(2, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const Frame f(i == 0 ? Vec3(0, 0, -1) : square_to_sphere(rng.next2()));
    EXPECT_NEAR(glm::dot(f.s, f.t), 0, 1e-6f);
    EXPECT_NEAR(glm::dot(f.s, f.n), 0, 1e-6f);
    EXPECT_NEAR(glm::length(f.s), 1, 1e-6f);
    EXPECT_NEAR(glm::distance(glm::cross(f.s, f.t), f.n), 0, 1e-6f);
  }
}

TEST(Octahedral, LosesLessThanFourThousandthsOfADegree) {
  Rng rng(6, RngPurpose::pilot, 0, 0);
  double worst = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Vec3 w = glm::normalize(square_to_sphere(rng.next2()));
    const glm::dvec3 d(decode_direction(encode_direction(w)));
    worst = std::max(worst, glm::length(glm::cross(d, glm::dvec3(w))));
  }
  EXPECT_LT(worst * 180 / kPi, 0.004);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 n = square_to_sphere(rng.next2());
    EXPECT_LT(glm::distance(decode_normal(encode_normal(n)), n), 0.1f * kPi / 180);
  }
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    EXPECT_LT(glm::distance(decode_direction(encode_direction(axis)), axis), 5e-5f);
  }
}

TEST(Warp, SquareOfATriangleIsFoundAgain) {
  Rng rng(5, RngPurpose::pilot, 0, 0);
  for (int i = 0; i < 10'000; ++i) {
    const Vec2 u = rng.next2(), again = triangle_to_square(square_to_triangle(u));
    EXPECT_NEAR(again.x, u.x, 4 * 0x1p-23f);
    EXPECT_NEAR(again.y, u.y, 4 * 0x1p-23f);
  }
  EXPECT_EQ(triangle_to_square({0, 0}), Vec2(0));
}

}  // namespace
}  // namespace photond
