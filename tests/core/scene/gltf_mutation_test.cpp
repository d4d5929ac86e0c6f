// Thousands of damaged files: read or refused, never a crash (also run under the address sanitizer).
#include <gtest/gtest.h>

#include <cstdint>

#include "core/scene/gltf.h"
#include "tests/support/glb.h"
#include "tests/support/scene_files.h"

namespace photond {
namespace {

/// A small deterministic generator (splitmix64), so that a failure repeats.
struct Random {
  std::uint64_t state;
  std::uint64_t next() {
    std::uint64_t z = state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
  }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(next() % n); }
};

/// Damages the file: bytes overwritten, mostly in its JSON, digits exchanged, or its end cut off. The length in
/// the header follows, as otherwise every truncated file would be refused there.
std::vector<std::byte> mutate(std::vector<std::byte> bytes, Random& random) {
  const std::size_t json_end = std::min<std::size_t>(bytes.size(), 4096);
  const std::size_t edits = 1 + random.below(4);
  for (std::size_t i = 0; i < edits; ++i) {
    const std::size_t at = random.below(random.below(4) == 0 ? bytes.size() : json_end);
    const bool digit = bytes[at] >= std::byte{'0'} && bytes[at] <= std::byte{'9'};
    bytes[at] = digit ? std::byte(static_cast<unsigned char>('0' + random.below(10)))
                      : std::byte(static_cast<unsigned char>(random.below(256)));
  }
  if (random.below(8) == 0) bytes.resize(20 + random.below(bytes.size() - 20));
  for (std::size_t i = 0; i < 4; ++i) bytes[8 + i] = std::byte(bytes.size() >> (8 * i) & 0xFF);
  return bytes;
}

int count_read(const std::vector<std::byte>& original, int rounds, std::uint64_t seed) {
  Random random{seed};
  int read = 0;
  SceneLimits limits;
  limits.max_vertices = limits.max_triangles = 1'000'000;
  for (int i = 0; i < rounds; ++i) {
    const Result<Scene> scene = read_gltf(mutate(original, random), no_resources(), limits);
    read += scene.ok();
    if (scene) {
      EXPECT_TRUE(is_finite(world_bounds(*scene).extent()));
    } else {
      EXPECT_FALSE(scene.error().message.empty());
    }
  }
  return read;
}

TEST(GltfMutation, DamagedTriangleIsReadOrRefused) {
  const std::vector<std::byte> original = test::GlbDraft().pack();
  const int read = count_read(original, 3000, 1);
  EXPECT_GT(read, 0);
  EXPECT_LT(read, 3000);
}

TEST(GltfMutation, DamagedRealFilesAreReadOrRefused) {
  const auto folder = test::shared_scenes();
  if (!folder) GTEST_SKIP() << "no shared scenes (set PHOTOND_SCENES)";
  for (const char* name : {"Box", "BoxTextured", "SimpleSparseAccessor", "SimpleInstancing", "SimpleMorph",
                           "Cameras", "TextureTransformTest", "BoxTextured.WebP", "MeshPrimitiveModes", "Box.Draco",
                           "Box.Meshopt"}) {
    SCOPED_TRACE(name);
    const std::vector<std::byte> original = test::read_file(*folder / "gltf" / (std::string(name) + ".glb"));
    ASSERT_FALSE(original.empty());
    EXPECT_LT(count_read(original, 300, 7), 300);
  }
}

}  // namespace
}  // namespace photond
