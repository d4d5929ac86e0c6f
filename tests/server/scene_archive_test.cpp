#include "server/jobs/scene_archive.h"

#include <gtest/gtest.h>
#include <zip.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/small_scene.h"

namespace photond {
namespace {

using Entries = std::vector<std::pair<std::string, std::string>>;

std::vector<std::byte> make_zip(const Entries& entries) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* target = zip_source_buffer_create(nullptr, 0, 0, &error);
  zip_source_keep(target);
  zip_t* zip = zip_open_from_source(target, ZIP_TRUNCATE, &error);
  for (const auto& [name, text] : entries) {
    zip_source_t* source = zip_source_buffer(zip, text.data(), text.size(), 0);
    zip_file_add(zip, name.c_str(), source, ZIP_FL_ENC_UTF_8);
  }
  EXPECT_EQ(zip_close(zip), 0);
  zip_source_open(target);
  zip_source_seek(target, 0, SEEK_END);
  std::vector<std::byte> bytes(static_cast<std::size_t>(zip_source_tell(target)));
  zip_source_seek(target, 0, SEEK_SET);
  zip_source_read(target, bytes.data(), bytes.size());
  zip_source_close(target);
  zip_source_free(target);
  return bytes;
}

ErrorCode refusal(const Entries& entries, const ArchiveLimits& limits = {}) {
  const auto archive = read_archive(make_zip(entries), limits);
  EXPECT_FALSE(archive.ok());
  return archive.ok() ? ErrorCode::internal : archive.error().code;
}

TEST(SceneArchive, ReadsResourcesBesideTheRootOnly) {
  const auto archive =
      read_archive(make_zip({{"a/scene.gltf", "{}"}, {"a/t/x.png", "pixels"}, {"x.png", "other"}}));
  ASSERT_TRUE(archive.ok()) << archive.error().message;
  EXPECT_EQ(archive->root, "a/scene.gltf");
  EXPECT_EQ(archive->root_bytes().size(), 2u);
  const ResourceReader read = archive->reader();
  EXPECT_EQ(read("t/x.png")->size(), 6u);
  EXPECT_FALSE(read("x.png").ok());
  EXPECT_FALSE(read("../x.png").ok());
  EXPECT_FALSE(read("/etc/passwd").ok());
}

TEST(SceneArchive, RefusesWhatIsNotOneScene) {
  EXPECT_EQ(refusal({{"readme.txt", "x"}}), ErrorCode::invalid_input);
  EXPECT_EQ(refusal({{"a.gltf", "{}"}, {"b.GLB", "x"}}), ErrorCode::invalid_input);
  EXPECT_EQ(refusal({{"../a.gltf", "{}"}}), ErrorCode::invalid_input);
  EXPECT_EQ(refusal({{"/a.gltf", "{}"}}), ErrorCode::invalid_input);
  EXPECT_EQ(refusal({{"b\\a.gltf", "{}"}}), ErrorCode::invalid_input);
}

TEST(SceneArchive, LeavesOutWhatMacOsPacksBesideTheFiles) {
  const auto archive = read_archive(make_zip({{"a/s.gltf", "{}"}, {"__MACOSX/a/._s.gltf", "attributes"}}));
  ASSERT_TRUE(archive.ok()) << archive.error().message;
  EXPECT_EQ(archive->root, "a/s.gltf");
  EXPECT_EQ(archive->files.size(), 1u);
}

// `zip -r - folder | curl …` does not go back to write sums and packed sizes, but the unpacked ones, which it knows.
TEST(SceneArchive, ReadsWhatWasPackedIntoAPipe) {
  constexpr std::byte kSizesFollow{8};
  std::vector<std::byte> zip = make_zip({{"a/s.gltf", "{}"}});
  constexpr std::byte kCentral[] = {std::byte{'P'}, std::byte{'K'}, std::byte{1}, std::byte{2}};
  const auto central = std::search(zip.begin(), zip.end(), std::begin(kCentral), std::end(kCentral));
  central[8] |= kSizesFollow;
  zip[6] |= kSizesFollow;
  std::fill_n(zip.begin() + 14, 8, std::byte{0});
  const auto archive = read_archive(zip);
  ASSERT_TRUE(archive.ok()) << archive.error().message;
  EXPECT_EQ(archive->root, "a/s.gltf");
  EXPECT_EQ(archive->root_bytes().size(), 2u);
}

TEST(SceneArchive, RefusesBombs) {
  EXPECT_EQ(refusal({{"a.gltf", "{}"}, {"b", std::string(8 << 20, '\0')}}), ErrorCode::limit_exceeded)
      << "ratio";
  ArchiveLimits limits;
  limits.max_bytes = 1000;
  EXPECT_EQ(refusal({{"a.gltf", "{}"}, {"b", std::string(999, 'x')}}, limits), ErrorCode::limit_exceeded);
  limits = {};
  limits.max_entries = 2;
  EXPECT_EQ(refusal({{"a.gltf", "{}"}, {"b", "x"}, {"c", "x"}}, limits), ErrorCode::limit_exceeded);
}

/// Why a scene is refused whose file names `quad.bin` as `copies` buffers, and wants a picture of 500 bytes.
Error refusal_of_copies(int copies) {
  nlohmann::json scene = nlohmann::json::parse(test::small_gltf());
  for (int i = 1; i < copies; ++i) scene["buffers"].push_back(scene["buffers"][0]);
  scene["images"] = {{{"uri", "x.png"}}};
  scene["textures"] = {{{"source", 0}}};
  scene["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  ArchiveLimits limits;
  limits.max_bytes = 10'000;  // 166 times quad.bin
  const auto archive = read_archive(
      make_zip({{"s.gltf", scene.dump()}, {"quad.bin", test::quad_bin()}, {"x.png", std::string(500, 'x')}}), limits);
  EXPECT_TRUE(archive.ok()) << archive.error().message;
  const auto read = read_gltf(archive->root_bytes(), archive->reader());
  EXPECT_FALSE(read.ok());
  return read.ok() ? Error{} : read.error();
}

TEST(SceneArchive, AFileNamedAgainAndAgainCountsEachTime) {
  EXPECT_EQ(refusal_of_copies(1).code, ErrorCode::unsupported) << "the picture was read, and is none";
  const Error picture = refusal_of_copies(160);
  EXPECT_EQ(picture.code, ErrorCode::limit_exceeded) << picture.message;
  EXPECT_EQ(picture.where, "images[0]");
  const Error buffer = refusal_of_copies(200);
  EXPECT_EQ(buffer.code, ErrorCode::limit_exceeded) << buffer.message;
  EXPECT_EQ(buffer.where, "buffers[166].uri");
}

TEST(SceneArchive, RefusesDamage) {
  std::vector<std::byte> zip = make_zip({{"a.gltf", std::string(5000, '{')}});
  EXPECT_FALSE(read_archive(std::span(zip).first(zip.size() / 2)).ok());
  EXPECT_FALSE(read_archive({}).ok());
  for (std::size_t i = 0; i < zip.size(); ++i) {  // no byte of it may lead to a crash
    std::vector<std::byte> changed = zip;
    changed[i] ^= std::byte{0xff};
    const auto archive = read_archive(changed);
    EXPECT_TRUE(!archive.ok() || archive->files.size() <= 1u);
  }
}

}  // namespace
}  // namespace photond
