#include "core/trace/prepare.h"

#include <gtest/gtest.h>

namespace photond {
namespace {

// The budget of prepared scenes is kept by this.
TEST(Prepare, CountsTheMemoryOfManySmallThings) {
  constexpr std::uint32_t kMany = 500;
  Scene scene;
  scene.materials.resize(kMany);
  for (std::uint32_t i = 0; i < kMany; ++i) {
    const auto x = static_cast<float>(i);
    scene.meshes.push_back(
        {.positions = {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}}, .triangles = {{0, 1, 2}}, .material = i});
    scene.instances.push_back({.mesh = i});
  }
  scene.cameras.resize(1);
  scene.environment.radiance = Rgb(1);
  const auto prepared = prepare(std::move(scene), {});
  ASSERT_TRUE(prepared.ok()) << prepared.error().message;
  EXPECT_GE((*prepared)->memory_bytes, kMany * (sizeof(Mesh) + sizeof(Material) + sizeof(Instance)));
}

}  // namespace
}  // namespace photond
