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

}  // namespace
}  // namespace photond
