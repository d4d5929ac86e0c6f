#include "core/photon/photon_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "core/math/rng.h"
#include "core/photon/photon_lanes.h"
#include "core/photon/photon_map.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

const Bounds3 kUnit{Vec3(0), Vec3(1)};

// Photons anywhere in a cube, numbered by their étendues.
std::vector<Photon> anywhere(std::uint32_t n, float side = 1) {
  Rng rng(21, RngPurpose::pilot, 0, n);
  std::vector<Photon> photons(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec2 u = rng.next2();
    photons[i] = {.position = side * Vec3(u.x, u.y, rng.next()), .flux = nearest_flux(Rgb(1)), .etendue = static_cast<float>(i)};
  }
  return photons;
}

TEST(PhotonCells, HoldEachPhotonOnceInItsCubeAndInTheOrderOfTheirComing) {
  // Few, and so many that chunks are given back.
  for (const std::uint32_t n : {0u, 1u, 1000u, 3'000'000u}) {
    const std::vector<Photon> photons = anywhere(n);
    PhotonCells cells(kUnit);
    for (std::uint32_t i = 0; i < n; i += 777) {
      cells.append(std::span(photons).subspan(i, std::min(777u, n - i)));
    }
    ASSERT_EQ(cells.size(), n);
    std::uint64_t seen = 0;
    for (std::uint32_t cell = 0; cell < MortonGrid::kCubes; ++cell) {
      std::uint64_t here = 0;
      float last = -1;
      for (const auto& span : cells.photons(cell)) {
        for (const Photon& photon : span) {
          ASSERT_EQ(cells.grid().cube(photon.position), cell);
          ASSERT_GT(photon.etendue, last);
          last = photon.etendue;
          ASSERT_EQ(photon.position, photons[static_cast<std::size_t>(last)].position);
        }
        here += span.size();
      }
      ASSERT_EQ(here, cells.size(cell));
      cells.free(cell);
      ASSERT_EQ(cells.size(cell), 0u);
      seen += here;
    }
    ASSERT_EQ(seen, n);
  }
}

TEST(PhotonCells, TellPhotonsApartInASmallPartOfThem) {
  const Vec3 a(0.25f), b = a + 2e-7f;   // within one 2²¹th of the side 10
  ASSERT_EQ(MortonGrid({Vec3(0), Vec3(10)}).code(a), MortonGrid({Vec3(0), Vec3(10)}).code(b));
  for (const bool spread : {false, true}) {
    PhotonCells cells({Vec3(0), Vec3(10)});
    cells.append(std::vector<Photon>{{.position = a}, {.position = spread ? Vec3(9) : b}});
    EXPECT_EQ(cells.fine_grid().code(a) == cells.fine_grid().code(b), spread);
  }
  EXPECT_EQ(PhotonCells(kUnit).fine_grid().code(Vec3(1)), MortonGrid(kUnit).code(Vec3(1)));   // without photons
}

TEST(MortonGrid, CubesAreNumberedAlongTheCurve) {
  const MortonGrid grid(kUnit);
  for (const Photon& photon : anywhere(10'000, 1.1f)) {
    const Vec3 p = photon.position - 0.05f;
    ASSERT_EQ(MortonGrid::cube_position(grid.cube(p)), glm::clamp(glm::floor(p * 8.0f), Vec3(0), Vec3(7)));
  }
}

TEST(MortonGrid, EightPartsAreThoseOfTheCodes) {
  const MortonGrid grid({Vec3(0.1f), Vec3(1)});
  const std::vector<Photon> photons = anywhere(10'001, 1.1f);   // some of them outside
  for (const int levels : {0, 3, 7}) {
    std::size_t seen = 0;
    for_parts(photons, grid, levels, [&](const Photon& photon, std::uint32_t part) {
      ASSERT_EQ(&photon, &photons[seen++]);
      ASSERT_EQ(part, MortonGrid::part(grid.code(photon.position), levels));
    });
    ASSERT_EQ(seen, photons.size());
  }
}

// Photons of one code, codes that differ in a single bit, and all that fits into 63.
TEST(MortonOrder, IsThatOfTheCodesButForAFew) {
  const MortonGrid grid(kUnit);
  for (const std::uint32_t n : {0u, 1u, 2u, 33u, 1000u, 40'000u}) {
    for (const int kind : {0, 1, 2, 3}) {
      std::vector<Photon> photons = anywhere(n);
      Rng rng(23, RngPurpose::pilot, 0, n);
      for (Photon& photon : photons) {
        if (kind == 1) photon.position *= rng.next() < 0.5f ? 1e-5f : 1.0f;      // half of them in a corner
        if (kind == 2) photon.position = Vec3(0.5f) + glm::floor(2.0f * photon.position) * 0x1p-20f;
        if (kind == 3) photon.position = Vec3(0.25f);
      }
      std::vector<std::span<const Photon>> spans;
      for (std::size_t i = 0; i < n; i += 1000) spans.push_back(std::span(photons).subspan(i, std::min(n - i, 1000ul)));
      const int levels = kind >= 2 ? MortonGrid::kCubeLevels : 0;   // those are in one cube
      const auto serial = morton_order(spans, grid, levels, Execution{});
      const auto parallel = morton_order(spans, grid, levels, test::workers().execution());
      std::vector<std::uint64_t> largest;   // codes so far
      std::vector<bool> seen(n);
      for (std::uint32_t i = 0; i < n; ++i) {
        const Photon& photon = serial[i].of(spans);
        ASSERT_EQ(&photon, &parallel[i].of(spans));
        const auto number = static_cast<std::uint32_t>(photon.etendue);
        ASSERT_FALSE(seen[number]);
        seen[number] = true;
        const std::uint64_t code = grid.code(photon.position);
        const auto larger = std::ranges::upper_bound(largest, code) - largest.begin();
        ASSERT_LT(i - larger, 32) << kind;
        ASSERT_TRUE(kind != 3 || number == i);
        largest.push_back(std::max(code, i == 0 ? 0 : largest.back()));
      }
    }
  }
}

// A small room under a large sky: the cells are the sky's, and still neighbours in the map are neighbours in the room.
TEST(PhotonCells, LeavesAreSmallWhereThePhotonsAreInOneCell) {
  const std::vector<Photon> photons = anywhere(100'000);
  PhotonCells cells({Vec3(-1e5f), Vec3(1e5f)});
  cells.append(photons);
  const PhotonMap map(std::move(cells), false, Execution{});
  double extent = 0;
  for (std::uint32_t i = 0; i < map.leaf_count(); ++i) {
    Bounds3 bounds;
    for (std::uint32_t k = 0; k < PhotonLeaf::kSize; ++k) bounds.add(map.position(PhotonLeaf::kSize * i + k));
    extent += static_cast<double>(max_component(bounds.extent())) / map.leaf_count();
  }
  EXPECT_LT(extent, 0.1);   // eight of 100 000 share a cube of 0.043
}

// Kilobytes, as Linux reports them of this process: VmRSS or VmHWM, the most since it was forgotten.
std::uint64_t resident(const std::string& field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(field + ":")) return std::stoull(line.substr(field.size() + 1));
  }
  return 0;
}

TEST(PhotonCellsStatistical, TwentyMillionPhotonsBecomeAMapWithinAGigabyte) {
  constexpr std::uint32_t kPhotons = 20'000'000, kBlock = 10'000;
  std::ofstream("/proc/self/clear_refs") << 5;   // forgets the peak
  const std::uint64_t before = resident("VmRSS");
  PhotonCells cells(kUnit);
  Rng rng(22, RngPurpose::pilot, 0, 0);
  std::vector<Photon> block(kBlock);
  for (std::uint32_t i = 0; i < kPhotons / kBlock; ++i) {
    for (Photon& photon : block) {
      const Vec2 u = rng.next2();
      photon = {.position = {u.x, u.y, rng.next()}, .flux = nearest_flux(Rgb(1))};
    }
    cells.append(block);
  }
  const PhotonMap map(std::move(cells), true, test::workers().execution());
  ASSERT_EQ(map.size(), kPhotons);
  const std::uint64_t peak = resident("VmHWM");
  ASSERT_GT(peak, before + 30 * (kPhotons / 1024));    // it was measured, if some were pages kept from before
  EXPECT_LT(1024 * (peak - before), 1'000'000'000u);
  EXPECT_LE(map.memory_bytes(), 36ull * kPhotons);
}

}  // namespace
}  // namespace photond
