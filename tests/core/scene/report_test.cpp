#include "core/scene/report.h"

#include <gtest/gtest.h>

namespace photond {
namespace {

std::vector<Camera> cameras(std::initializer_list<std::string> names) {
  std::vector<Camera> result;
  for (const std::string& name : names) result.emplace_back().name = name;
  return result;
}

TEST(UnknownCamera, NamesThoseThereAre) {
  EXPECT_EQ(unknown_camera("x", cameras({"main", "corner"})), "there is no camera 'x'; there are 'main', 'corner'");
}

TEST(UnknownCamera, OfLongNamesItTakesWholeCharacters) {
  std::string many;
  for (int i = 0; i < 40; ++i) many += "é";   // two bytes each
  const std::string thirty = many.substr(0, 60);
  EXPECT_EQ(unknown_camera(many, cameras({"main"})), "there is no camera '" + thirty + "'; there are 'main'");
  EXPECT_EQ(unknown_camera("a" + many, cameras({"main"})),
            "there is no camera 'a" + many.substr(0, 58) + "'; there are 'main'");
  EXPECT_EQ(unknown_camera("x", cameras({"a" + many})), "there is no camera 'x'; there are 'a" + many.substr(0, 58) + "'");
}

TEST(UnknownCamera, OfManyItNamesEight) {
  std::vector<Camera> many(10);
  for (Camera& camera : many) camera.name = "c";
  EXPECT_EQ(unknown_camera("x", many),
            "there is no camera 'x'; there are 'c', 'c', 'c', 'c', 'c', 'c', 'c', 'c' and 2 more");
}

TEST(SceneReport, MemoryGrowsWithEntriesAndNames) {
  Scene scene;
  const std::uint64_t empty = memory_bytes(make_report(scene));
  scene.cameras.resize(1000);
  EXPECT_GT(memory_bytes(make_report(scene)), empty + 1000 * sizeof(SceneReport::CameraEntry) - 1);
  scene.materials.push_back({.name = std::string(100'000, 'x')});
  scene.warnings.push_back(std::string(100'000, 'x'));
  EXPECT_GT(memory_bytes(make_report(scene)), empty + 200'000);
}

}  // namespace
}  // namespace photond
