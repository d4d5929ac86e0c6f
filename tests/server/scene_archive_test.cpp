#include "server/jobs/scene_archive.h"

#include <gtest/gtest.h>
#include <zip.h>

#include <cstring>
#include <string>
#include <utility>
#include <vector>

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
