#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "server/cli/load_scene.h"
#include "tests/cli/program.h"

namespace photond::test {
namespace {

/// A scene folder beside a file that must stay unread.
class SceneFolder : public ::testing::Test {
 protected:
  SceneFolder() {
    std::filesystem::create_directories(scene_ / "parts");
    write_text(outer_.path() / "secret.bin", std::string(108, 'x'));
    write_scene(scene_);
  }

  TemporaryFolder outer_;
  std::filesystem::path scene_ = outer_.path() / "scene";
};

TEST_F(SceneFolder, ReadsResourcesBesideTheScene) {
  std::filesystem::copy(scene_ / "scene.bin", scene_ / "parts" / "inner.bin");
  std::filesystem::create_symlink("parts/inner.bin", scene_ / "link.bin");
  const ResourceReader read = folder_resources(scene_);
  for (const char* name : {"scene.bin", "parts/inner.bin", "link.bin", "./scene.bin"}) {
    const auto bytes = read(name);
    ASSERT_TRUE(bytes.ok()) << name << ": " << bytes.error().message;
    EXPECT_EQ(bytes->size(), 108u);
  }
}

TEST_F(SceneFolder, RefusesWhatLiesOutside) {
  std::filesystem::create_symlink("../secret.bin", scene_ / "link.bin");
  std::filesystem::create_directory_symlink("..", scene_ / "up");
  const ResourceReader read = folder_resources(scene_);
  const std::string absolute = (outer_.path() / "secret.bin").string();
  for (const std::string& name : {std::string("../secret.bin"), std::string("parts/../../secret.bin"), absolute,
                                  std::string("link.bin"), std::string("up/secret.bin"), std::string()}) {
    const auto bytes = read(name);
    ASSERT_FALSE(bytes.ok()) << name;
    EXPECT_EQ(bytes.error().code, ErrorCode::invalid_input) << name;
    EXPECT_NE(bytes.error().message.find("'" + name + "'"), std::string::npos) << bytes.error().message;
  }
  EXPECT_EQ(read("parts").error().code, ErrorCode::io);
  EXPECT_EQ(read("missing.bin").error().code, ErrorCode::not_found);
  EXPECT_EQ(read("missing.bin").error().message, "'missing.bin' does not exist in the scene's folder");
}

TEST_F(SceneFolder, TheProgramRefusesUrisThatLeadOutside) {
  const std::string absolute = (outer_.path() / "secret.bin").string();
  std::filesystem::create_symlink("../secret.bin", scene_ / "link.bin");
  for (const std::string& uri : {std::string("../secret.bin"), std::string("%2e%2e/secret.bin"), absolute,
                                 "file://" + absolute, std::string("link.bin")}) {
    const Outcome run = run_photond({"info", write_scene(scene_, uri)});
    EXPECT_EQ(run.code, 1) << uri << "\n" << run.out;
    EXPECT_NE(run.err.find("scene.gltf"), std::string::npos) << run.err;
  }
}

TEST_F(SceneFolder, InfoListsWhatTheFileHolds) {
  const Outcome run = run_photond({"info", "--json", write_scene(scene_)});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["counts"]["triangles"], 4);
  EXPECT_EQ(json["counts"]["emissive_triangles"], 2);
  EXPECT_EQ(json["materials"].size(), 2u);
  EXPECT_EQ(json["bounds"]["min"], (std::vector<double>{-1, 0, -1}));
  EXPECT_EQ(json["bounds"]["max"], (std::vector<double>{1, 1, 1}));
  ASSERT_EQ(json["cameras"].size(), 1u);
  EXPECT_EQ(json["cameras"][0]["name"], "above");
  EXPECT_EQ(json["materials"][0]["name"], "white");
  EXPECT_EQ(json["digest"].get<std::string>().size(), 64u);
  EXPECT_TRUE(json["warnings"].is_array());
  EXPECT_NE(json["plan"]["method"], "auto");
  for (const auto& item : json["plan"]["items"]) EXPECT_NE(item["reason"], "");

  const Outcome text = run_photond({"info", write_scene(scene_)});
  EXPECT_EQ(text.code, 0);
  EXPECT_NE(text.out.find("'above'"), std::string::npos) << text.out;
}

TEST_F(SceneFolder, NamesDoNotSteerTheTerminal) {
  const std::string file = write_scene(scene_);
  auto scene = nlohmann::json::parse(read_text(file));
  scene["cameras"][0]["name"] = "a\x1b[31m\xc2\x9b" "b\nc é";
  scene["extensionsUsed"].push_back("EXT_\x1b[2J");
  write_text(file, scene.dump());
  const Outcome info = run_photond({"info", file});
  EXPECT_EQ(info.code, 0) << info.err;
  EXPECT_NE(info.out.find("'a?[31m?b c é'"), std::string::npos) << info.out;
  EXPECT_NE(info.out.find("EXT_?[2J ignored"), std::string::npos) << info.out;
  scene["extensionsRequired"] = {"EXT_\x1b[2J"};
  write_text(file, scene.dump());
  EXPECT_NE(run_photond({"info", file}).err.find("EXT_?[2J"), std::string::npos);
}

TEST(FindCamera, PrefersTheNameAndThenTheIndex) {
  Scene scene;
  scene.cameras.resize(3);
  scene.cameras[0].name = "2";
  scene.cameras[1].name = "side";
  scene.cameras[2].name = "top";
  EXPECT_EQ(find_camera(scene, "")->name, "2");
  EXPECT_EQ(find_camera(scene, "side")->name, "side");
  EXPECT_EQ(find_camera(scene, "2")->name, "2");
  EXPECT_EQ(find_camera(scene, "1")->name, "side");
  for (const char* wrong : {"3", "-1", "1x", "front"}) {
    const auto camera = find_camera(scene, wrong);
    ASSERT_FALSE(camera.ok()) << wrong;
    EXPECT_EQ(camera.error().code, ErrorCode::not_found);
    EXPECT_NE(camera.error().message.find("'side'"), std::string::npos);
  }
}

}  // namespace
}  // namespace photond::test
