#include "core/math/float8.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/math/octahedral.h"
#include "core/math/rng.h"
#include "core/photon/packed_flux.h"

namespace photond {
namespace {

using Eight = std::array<float, 8>;

Eight random_eight(Rng& rng) {
  Eight values;
  for (float& v : values) v = 2 * rng.next() - 1;
  return values;
}

TEST(Float8, PutsWhatIsSetInOrder) {
  for (std::uint32_t bits = 0; bits < 256; ++bits) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t k = 0; k < 8; ++k) {
      if ((bits >> k & 1) != 0) expected.push_back(1000 + 16 * k);
    }
    std::array<std::uint32_t, 8> found{};
    const std::uint32_t count = put_set8(bits, 1000, 16, found.data());
    EXPECT_EQ(std::vector<std::uint32_t>(found.begin(), found.begin() + count), expected) << bits;
  }
}

TEST(Float8, ReducesAllEight) {
  Rng rng(1, RngPurpose::pilot, 0, 0);
  for (int round = 0; round < 100; ++round) {
    const Eight values = random_eight(rng);
    double sum = 0;
    for (const float v : values) sum += static_cast<double>(v);
    const Float8 v = load8(values.data());
    EXPECT_NEAR(static_cast<double>(sum8(v)), sum, 1e-6);
    EXPECT_EQ(least8(v), *std::ranges::min_element(values));
    std::uint32_t negative = 0;
    for (std::uint32_t k = 0; k < 8; ++k) negative |= (values[k] < 0 ? 1u : 0u) << k;
    EXPECT_EQ(bits8(v < 0), negative);
    EXPECT_EQ(any8(v < 0), negative != 0);
    for (std::uint32_t k = 0; k < 8; ++k) {
      EXPECT_EQ(abs8(v)[k], std::abs(values[k]));
      EXPECT_EQ(sqrt8(abs8(v))[k], std::sqrt(std::abs(values[k])));
      EXPECT_EQ(copysign8(abs8(v), -v)[k], -values[k]);
    }
  }
}

TEST(Float8, LooksUpInATable) {
  std::array<float, 32> table;
  for (std::uint32_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(i * i);
  const Mask8 index{31, 0, 7, 8, 30, 7, 1, 16};
  for (std::uint32_t k = 0; k < 8; ++k) {
    EXPECT_EQ(lookup8(table.data(), index)[k], table[static_cast<std::uint32_t>(index[k])]);
  }
}

TEST(Float8, DecodesAsOneAfterTheOther) {
  Rng rng(2, RngPurpose::pilot, 0, 0);
  for (int round = 0; round < 100; ++round) {
    std::array<std::uint32_t, 8> normals, directions;
    std::array<std::uint16_t, 8> fluxes;
    for (std::uint32_t k = 0; k < 8; ++k) {
      const Vec3 unit = glm::normalize(Vec3(rng.next() - 0.5f, rng.next() - 0.5f, rng.next() - 0.5f));
      normals[k] = encode_normal(unit);
      directions[k] = encode_direction(unit);
      fluxes[k] = nearest_flux(Rgb(std::exp2(60 * rng.next() - 30)))[0];
    }
    const Vec3x8 normal = decode_normal(reinterpret_cast<Bits8>(load8(normals.data())));
    const Vec3x8 direction = decode_direction(reinterpret_cast<Bits8>(load8(directions.data())));
    const Float8 flux = decode_flux(fluxes);
    for (std::uint32_t k = 0; k < 8; ++k) {
      EXPECT_EQ(Vec3(normal.x[k], normal.y[k], normal.z[k]), decode_normal(normals[k]));
      EXPECT_LT(glm::distance(Vec3(direction.x[k], direction.y[k], direction.z[k]), decode_direction(directions[k])), 3e-7f);
      EXPECT_EQ(flux[k], decode_flux(fluxes[k]));
    }
  }
}

}  // namespace
}  // namespace photond
