#include "core/photon/map_bytes.h"

#include <gtest/gtest.h>

#include <cstring>

#include "core/photon/photon_stage.h"
#include "core/render/render.h"
#include "tests/support/scenes.h"

namespace photond {
namespace {

// A file in memory, aligned as a mapping is.
struct FileBytes {
  std::shared_ptr<std::byte> memory;
  std::size_t size = 0;

  explicit FileBytes(std::size_t n) : memory(static_cast<std::byte*>(std::aligned_alloc(64, (n + 63) / 64 * 64)), std::free), size(n) {}
  std::span<std::byte> bytes() const { return {memory.get(), size}; }
  SharedSpan shared() const { return {bytes(), memory}; }
  FileBytes copy(std::size_t n) const {
    FileBytes other(n);
    std::memcpy(other.memory.get(), memory.get(), std::min(n, size));
    if (n > size) std::memset(other.memory.get() + size, 0, n - size);
    return other;
  }
};

FileBytes file_of(SectionList list, const Digest& identity) {
  std::size_t size = 0;
  const auto pieces = list.pieces(identity, Execution{});
  for (const auto& piece : pieces) size += piece.size();
  FileBytes file(size);
  std::byte* to = file.memory.get();
  for (const auto& piece : pieces) {
    if (!piece.empty()) std::memcpy(to, piece.data(), piece.size());
    to += piece.size();
  }
  return file;
}

class MapBytes : public ::testing::Test {
 protected:
  void SetUp() override {
    scene_ = test::busy_room();
    key_.scene = scene_->digest;
    key_.settings.photons_per_pass = 3000;
    maps_ = *build_photon_maps(*scene_, key_, Execution{});
    irradiance_key_ = irradiance_key(scene_->digest, key_.settings);
    guide_key_ = guide_key(scene_->digest, key_.settings);
    guide_ = *build_gather_guide(*scene_, guide_key_, Execution{});
  }

  FileBytes maps_file() const { return file_of(map_sections(*maps_, 0.5), map_identity(key_)); }
  FileBytes guide_file() const { return file_of(guide_sections(*guide_, 0.25), map_identity(guide_key_)); }
  bool reads(const FileBytes& file, const MapKey& key) const {
    return is_guide_key(key) ? read_gather_guide(file.shared(), key, Execution{}) != nullptr
                             : read_photon_maps(file.shared(), key, Execution{}) != nullptr;
  }

  std::shared_ptr<const PreparedScene> scene_;
  MapKey key_, irradiance_key_, guide_key_;
  std::shared_ptr<const PhotonMaps> maps_;
  std::shared_ptr<const GatherGuide> guide_;
};

TEST_F(MapBytes, MapsReadBackAreTheSameInPlace) {
  const FileBytes file = maps_file();
  const auto read = read_photon_maps(file.shared(), key_, test::workers().execution());
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(read->emitted, maps_->emitted);
  EXPECT_EQ(read->rays, maps_->rays);
  EXPECT_EQ(std::memcmp(&read->ledger, &maps_->ledger, sizeof(EnergyLedger)), 0);
  EXPECT_EQ(read->memory_bytes, maps_->memory_bytes);
  EXPECT_GT(maps_->caustic.size(), 0u);
  EXPECT_TRUE(maps_->caustic.has_etendues());
  const auto& leaf = read->global.leaf(0);
  EXPECT_GE(reinterpret_cast<const std::byte*>(&leaf), file.bytes().data()) << "used where it lies";
  EXPECT_LT(reinterpret_cast<const std::byte*>(&leaf), file.bytes().data() + file.size);
  for (const auto& [a, b] : {std::pair(&read->global, &maps_->global), std::pair(&read->caustic, &maps_->caustic)}) {
    ASSERT_EQ(a->size(), b->size());
    EXPECT_EQ(std::memcmp(a->leaves().data(), b->leaves().data(), b->leaves().size_bytes()), 0);
    ASSERT_EQ(a->has_etendues(), b->has_etendues());
    EXPECT_EQ(std::memcmp(a->etendues().data(), b->etendues().data(), b->etendues().size_bytes()), 0);
    EXPECT_EQ(std::memcmp(a->tree().nodes().data(), b->tree().nodes().data(), b->tree().nodes().size()), 0);
  }
  EXPECT_EQ(maps_file().size, file.size);
  EXPECT_EQ(std::memcmp(maps_file().memory.get(), file.memory.get(), file.size), 0) << "one map, one file";
}

TEST_F(MapBytes, IrradianceReadBackIsTheSame) {
  const auto maps = *build_photon_maps(*scene_, irradiance_key_, Execution{});
  const FileBytes file = file_of(map_sections(*maps, 0.5), map_identity(irradiance_key_));
  EXPECT_FALSE(reads(file, key_)) << "another key";
  const auto read = read_photon_maps(file.shared(), irradiance_key_, Execution{});
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(read->irradiance.reach(), maps->irradiance.reach());
  EXPECT_EQ(read->memory_bytes, maps->memory_bytes);
  const auto a = read->irradiance.places().leaves(), b = maps->irradiance.places().leaves();
  ASSERT_GT(a.size(), 0u);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0);
  for (std::uint32_t i = 0; i < maps->irradiance.places().size(); ++i) {
    const Vec3 position = maps->irradiance.places().position(i), normal = maps->irradiance.places().normal(i);
    EXPECT_EQ(read->irradiance.nearest(Edges(), position, normal), maps->irradiance.nearest(Edges(), position, normal));
  }
}

TEST_F(MapBytes, TheFileLivesAsLongAsTheMaps) {
  std::weak_ptr<std::byte> memory;
  {
    std::shared_ptr<const PhotonMaps> read;
    {
      const FileBytes file = maps_file();
      memory = file.memory;
      read = read_photon_maps(file.shared(), key_, Execution{});
    }
    EXPECT_FALSE(memory.expired());
    EXPECT_GE(read->global.flux(0).x, 0);
  }
  EXPECT_TRUE(memory.expired());
}

TEST_F(MapBytes, PicturesByMapsAndGuideReadBackHaveTheSameBits) {
  const auto with_irradiance = *build_photon_maps(*scene_, irradiance_key_, Execution{});
  const FileBytes guide = guide_file();
  for (const Method method : {Method::progressive, Method::photon_map, Method::hybrid}) {
    RenderSettings settings{.method = method, .width = 24, .height = 18};
    const auto picture = [&](const GuideSource& guides, std::shared_ptr<const PhotonMaps> with) {
      const auto task = make_render_task(scene_, scene_->scene.cameras[0], key_.settings, settings, Execution{}, guides);
      const MapSource source = [&](const MapKey&, const Execution&) { return Result(with); };
      return *render_pass(*task, 0, source, Execution{});
    };
    const bool irradiance = method == Method::photon_map;
    const auto& with = irradiance ? with_irradiance : maps_;
    const MapKey& key = irradiance ? irradiance_key_ : key_;
    const FileBytes maps = file_of(map_sections(*with, 0.5), map_identity(key));
    const PassImage built = picture(build_gather_guide, with);
    const GuideSource from_file = [&](const PreparedScene&, const MapKey& asked, const Execution& execution) {
      return Result(read_gather_guide(guide.shared(), asked, execution));
    };
    const PassImage read = picture(from_file, read_photon_maps(maps.shared(), key, Execution{}));
    ASSERT_EQ(built.radiance.pixels.size(), read.radiance.pixels.size());
    EXPECT_EQ(std::memcmp(built.radiance.pixels.data(), read.radiance.pixels.data(),
                          built.radiance.pixels.size() * sizeof(Rgb)), 0);
    ASSERT_EQ(built.bands.size(), read.bands.size());
    if (!built.bands.empty()) {
      EXPECT_EQ(std::memcmp(built.bands.data(), read.bands.data(), built.bands.size() * sizeof(Bands)), 0);
    }
  }
}

TEST_F(MapBytes, EveryFlippedBitOfTheHeadIsNoticed) {
  const FileBytes file = maps_file();
  for (std::size_t bit = 0; bit < 8 * Sections::kHeadBytes; ++bit) {
    const FileBytes damaged = file.copy(file.size);
    damaged.bytes()[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    EXPECT_FALSE(reads(damaged, key_)) << bit;
  }
}

// Anywhere: leaves, trees, densities, edges and the gaps between them.
TEST_F(MapBytes, FlippedBitsAreNoticed) {
  for (const auto& [file, key] : {std::pair(maps_file(), key_), std::pair(guide_file(), guide_key_)}) {
    ASSERT_TRUE(reads(file, key));
    Rng rng(7, RngPurpose::pilot, 0, 0);
    for (int i = 0; i < 2000; ++i) {
      const FileBytes damaged = file.copy(file.size);
      const int flips = 1 + i % 3;
      std::vector<std::size_t> bits;
      for (int k = 0; k < flips; ++k) {
        const auto at = static_cast<std::size_t>(static_cast<double>(rng.next()) * static_cast<double>(8 * file.size));
        bits.push_back(at);
        damaged.bytes()[at / 8] ^= static_cast<std::byte>(1 << at % 8);
      }
      if (flips == 2 && bits[0] == bits[1]) continue;
      EXPECT_FALSE(reads(damaged, key)) << bits.front();
    }
  }
}

// The highest bits of two words in the same place of a stride: what a sum by multiplication alone would not see.
TEST_F(MapBytes, PairsOfFlippedHighBitsAreNoticed) {
  const FileBytes file = maps_file();
  for (std::size_t at = Sections::kHeadBytes + 128 + 7; at + 64 < 20'000; at += 64) {
    const FileBytes damaged = file.copy(file.size);
    for (const std::size_t i : {at, at + 64}) damaged.bytes()[i] ^= std::byte{0x80};
    EXPECT_FALSE(reads(damaged, key_)) << at;
  }
}

TEST_F(MapBytes, CutAndGrownFilesAreNoticed) {
  for (const auto& [file, key] : {std::pair(maps_file(), key_), std::pair(guide_file(), guide_key_)}) {
    std::vector<std::size_t> sizes{0, 1, 7, 8, 40, 63, 64, Sections::kHeadBytes - 1, Sections::kHeadBytes,
                                   file.size / 2, file.size - 64, file.size - 1, file.size + 1, file.size + 64,
                                   2 * file.size};
    for (std::size_t size = 0; size < file.size; size += 997) sizes.push_back(size);
    for (const std::size_t size : sizes) EXPECT_FALSE(reads(file.copy(size), key)) << size << " of " << file.size;
  }
}

// A page that was never written reads as zeros.
TEST_F(MapBytes, LostPagesAreNoticed) {
  const FileBytes file = maps_file();
  for (std::size_t page = 0; page < file.size; page += 4096) {
    const FileBytes damaged = file.copy(file.size);
    const auto lost = damaged.bytes().subspan(page, std::min<std::size_t>(4096, file.size - page));
    std::ranges::fill(lost, std::byte{0});
    EXPECT_FALSE(reads(damaged, key_)) << page;
  }
}

TEST_F(MapBytes, FilesOfOthersAreNoticed) {
  EXPECT_FALSE(reads(guide_file(), key_));
  EXPECT_FALSE(reads(maps_file(), guide_key_));
  MapKey other = key_;
  other.pass = 1;
  EXPECT_FALSE(reads(maps_file(), other));
  other = key_;
  other.settings.seed = 1;
  EXPECT_FALSE(reads(maps_file(), other));
  other = key_;
  other.scene.bytes[31] ^= 1;
  EXPECT_FALSE(reads(maps_file(), other));
  // Of another program: the identity is another, everything else is right.
  Digest identity = map_identity(key_);
  identity.bytes[0] ^= 1;
  EXPECT_FALSE(reads(file_of(map_sections(*maps_, 0.5), identity), key_));
  // With the right identity, but other contents.
  EXPECT_FALSE(reads(file_of(guide_sections(*guide_, 0.25), map_identity(key_)), key_));
  SectionList nothing;
  EXPECT_FALSE(reads(file_of(std::move(nothing), map_identity(key_)), key_));
}

TEST_F(MapBytes, UnalignedBytesAreRefused) {
  const FileBytes file = maps_file();
  FileBytes moved(file.size + 8);
  std::memcpy(moved.memory.get() + 8, file.memory.get(), file.size);
  EXPECT_EQ(read_photon_maps({moved.bytes().subspan(8), moved.memory}, key_, Execution{}), nullptr);
}

TEST_F(MapBytes, TheFirstBytesTellTheFacts) {
  const FileBytes maps = maps_file(), guide = guide_file();
  const auto facts = read_facts(maps.bytes().first(kFactsBytes), key_);
  ASSERT_TRUE(facts);
  EXPECT_EQ(facts->global, maps_->global.size());
  EXPECT_EQ(facts->caustic, maps_->caustic.size());
  EXPECT_EQ(facts->build_seconds, 0.5);
  EXPECT_EQ(read_facts(guide.bytes().first(kFactsBytes), guide_key_)->build_seconds, 0.25);
  EXPECT_FALSE(read_facts(maps.bytes().first(kFactsBytes), guide_key_));
  EXPECT_FALSE(read_facts(maps.bytes().first(kFactsBytes - 1), key_));
}

TEST_F(MapBytes, EmptyMapsAreKept) {
  const auto dark = test::prepared(test::empty_scene());
  const MapKey key{dark->digest, {100, 0}, 0};
  const auto maps = *build_photon_maps(*dark, key, Execution{});
  const auto read = read_photon_maps(file_of(map_sections(*maps, 0), map_identity(key)).shared(), key, Execution{});
  ASSERT_NE(read, nullptr);
  EXPECT_EQ(read->global.size(), 0u);
  const MapKey of_guide = guide_key(dark->digest, key.settings);
  const auto guide = *build_gather_guide(*dark, of_guide, Execution{});
  EXPECT_NE(read_gather_guide(file_of(guide_sections(*guide, 0), map_identity(of_guide)).shared(), of_guide, Execution{}),
            nullptr);
}

TEST(PhotonStage, IsOneForAProgram) {
  EXPECT_EQ(photon_stage(), photon_stage());
  EXPECT_NE(photon_stage(), Digest{});
}

TEST(Checksum, DoesNotDependOnTheThreads) {
  std::vector<std::byte> bytes(3'000'001);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * i >> 7);
  EXPECT_EQ(checksum(bytes, Execution{}), checksum(bytes, test::workers().execution()));
  EXPECT_NE(checksum(bytes, Execution{}), checksum(std::span(bytes).first(3'000'000), Execution{}));
}

}  // namespace
}  // namespace photond
