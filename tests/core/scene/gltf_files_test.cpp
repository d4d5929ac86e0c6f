// Files by others: what must be read, refused or survived.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <tuple>

#include "core/scene/gltf.h"
#include "tests/support/scene_files.h"

namespace photond {
namespace {

using Clock = std::chrono::steady_clock;

nlohmann::json manifest(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = test::read_file(path);
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  return nlohmann::json::parse(text, text + bytes.size());
}

long peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024;
}

void expect_sound(const Scene& scene) {
  ASSERT_FALSE(scene.cameras.empty());
  ASSERT_FALSE(scene.instances.empty());
  for (const Instance& instance : scene.instances) ASSERT_LT(instance.mesh, scene.meshes.size());
  for (const Mesh& mesh : scene.meshes) {
    ASSERT_LT(mesh.material, scene.materials.size());
    for (const auto* per_vertex : {&mesh.uv[0], &mesh.uv[1]}) {
      EXPECT_TRUE(per_vertex->empty() || per_vertex->size() == mesh.positions.size());
    }
    for (const Vec3& p : mesh.positions) ASSERT_TRUE(is_finite(p));
    for (const Vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-5);
    for (const glm::uvec3& t : mesh.triangles) {
      ASSERT_LT(std::max({t.x, t.y, t.z}), mesh.positions.size());
    }
  }
  for (const Texture& texture : scene.textures) ASSERT_LT(texture.image, scene.images.size());
  EXPECT_TRUE(is_finite(world_bounds(scene).extent()));
}

bool is_clean(const std::string& path) {
  return !path.empty() && path.front() != '/' && path.find("..") == std::string::npos &&
         path.find(':') == std::string::npos && path.find('\\') == std::string::npos;
}

TEST(GltfFiles, HostileFilesAreRefusedOrSurvived) {
  const auto folder = test::shared_scenes();
  if (!folder) GTEST_SKIP() << "no shared scenes (set PHOTOND_SCENES)";
  const nlohmann::json entries = manifest(*folder / "invalid/manifest.json");
  ASSERT_GT(entries.size(), 100u);
  const long before = peak_megabytes();
  for (const auto& entry : entries) {
    const std::string file = entry["file"], expect = entry["expect"];
    SCOPED_TRACE(file);
    const std::filesystem::path path = *folder / file;
    std::vector<std::string> asked;
    const Clock::time_point start = Clock::now();
    const Result<Scene> scene =
        read_gltf(test::read_file(path), test::folder_reader(path.parent_path(), &asked));
    EXPECT_LT(std::chrono::duration<double>(Clock::now() - start).count(), 2);
    for (const std::string& name : asked) EXPECT_TRUE(is_clean(name)) << name;
    if (scene) {
      EXPECT_NE(expect, "must_reject");
      expect_sound(*scene);
    } else {
      EXPECT_FALSE(scene.error().message.empty());
      EXPECT_NE(scene.error().code, ErrorCode::internal);
    }
  }
  // None of the files is larger than a few megabytes, nor is any picture in them.
  EXPECT_LT(peak_megabytes() - before, 300);
}

TEST(GltfFiles, RealFilesAreReadOrNameTheMissingExtension) {
  const auto folder = test::shared_scenes();
  if (!folder) GTEST_SKIP() << "no shared scenes (set PHOTOND_SCENES)";
  int read = 0;
  for (const char* group : {"gi", "gltf"}) {
    for (const auto& file : std::filesystem::directory_iterator(*folder / group)) {
      if (file.path().extension() != ".glb") continue;
      SCOPED_TRACE(file.path().filename().string());
      const Result<Scene> scene = read_gltf(test::read_file(file.path()), no_resources());
      if (scene) {
        ++read;
        expect_sound(*scene);
        continue;
      }
      EXPECT_EQ(scene.error().code, ErrorCode::unsupported) << scene.error().message;
      EXPECT_NE(scene.error().where.find("extensionsRequired"), std::string::npos) << scene.error().where;
    }
  }
  EXPECT_GT(read, 40);
}

/// The corners of all triangles in the world, in an order that does not depend on the file's.
std::vector<Vec3> sorted_corners(const Scene& scene) {
  std::vector<Vec3> out;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const glm::uvec3& t : mesh.triangles) {
      for (const std::uint32_t i : {t.x, t.y, t.z}) out.push_back(instance.to_world * Vec4(mesh.positions[i], 1));
    }
  }
  const auto sign = [](float x) { return x > 0; };
  std::ranges::sort(out, {}, [&](const Vec3& p) { return std::tuple(sign(p.x), sign(p.y), sign(p.z)); });
  return out;
}

TEST(GltfFiles, CompressedBoxesAreTheBox) {
  const auto folder = test::shared_scenes();
  if (!folder) GTEST_SKIP() << "no shared scenes (set PHOTOND_SCENES)";
  const Result<Scene> box = read_gltf(test::read_file(*folder / "gltf/Box.glb"), no_resources());
  ASSERT_TRUE(box.ok());
  const std::vector<Vec3> expected = sorted_corners(*box);
  for (const char* name : {"Box.Draco.glb", "Box.Meshopt.glb"}) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = read_gltf(test::read_file(*folder / "gltf" / name), no_resources());
    ASSERT_TRUE(scene.ok()) << scene.error().where << ": " << scene.error().message;
    const std::vector<Vec3> corners = sorted_corners(*scene);
    ASSERT_EQ(corners.size(), expected.size());
    for (std::size_t i = 0; i < corners.size(); ++i) EXPECT_LT(glm::distance(corners[i], expected[i]), 1e-3);
  }
}

TEST(GltfFiles, SamplesAreReadWithoutWarning) {
  for (const char* name : {"cornell_box", "glass_and_mirror", "pool", "lantern"}) {
    SCOPED_TRACE(name);
    const auto path = std::filesystem::path(PHOTOND_SAMPLES_DIR) / (std::string(name) + ".glb");
    const Result<Scene> scene = read_gltf(test::read_file(path), no_resources());
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    expect_sound(*scene);
    EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
    EXPECT_EQ(scene->cameras.front().name, "main");
    EXPECT_GE(scene->cameras.size(), 2u);
  }
}

}  // namespace
}  // namespace photond
