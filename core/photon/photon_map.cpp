#include "core/photon/photon_map.h"

#include <algorithm>
#include <ranges>
#include <vector>

namespace photond {

namespace {

void set(PhotonLeaf& leaf, std::uint32_t lane, const Photon& photon, std::uint64_t index) {
  leaf.x[lane] = photon.position.x;
  leaf.y[lane] = photon.position.y;
  leaf.z[lane] = photon.position.z;
  leaf.normal[lane] = photon.normal;
  leaf.direction[lane] = photon.direction;
  const PackedFlux flux = encode_flux(photon.flux, index);
  for (int c = 0; c < 3; ++c) leaf.flux[c][lane] = flux[c];
}

Bounds3 bounds_of(const PhotonLeaf& leaf, std::uint32_t count) {
  Bounds3 bounds;
  for (std::uint32_t i = 0; i < count; ++i) bounds.add({leaf.x[i], leaf.y[i], leaf.z[i]});
  return bounds;
}

// Leaves between asking for photons and reading them.
constexpr std::size_t kAhead = 3;

// Pieces of a size that is worth a task.
std::vector<std::span<const Photon>> pieces(std::span<const Photon> photons) {
  constexpr std::size_t kPiece = 8192;
  std::vector<std::span<const Photon>> blocks;
  for (std::size_t i = 0; i < photons.size(); i += kPiece) {
    blocks.push_back(photons.subspan(i, std::min(kPiece, photons.size() - i)));
  }
  return blocks;
}

}  // namespace

PhotonMap::PhotonMap(PhotonSpans blocks, std::span<const std::span<const float>> etendues,
                     const Execution& execution) {
  std::vector<std::uint64_t> first;                // index of each block's first photon
  std::uint64_t n = 0;
  for (const auto& block : blocks) {
    first.push_back(n);
    n += block.size();
  }
  size_ = static_cast<std::uint32_t>(n);
  grid_ = MortonGrid(bounds_of(blocks, execution));
  const auto order = morton_order(blocks, grid_, execution);
  leaves_ = make_large_array<PhotonLeaf>(leaf_count());
  if (!etendues.empty()) etendues_ = make_large_array<PhotonLeaf::Lanes<float>>(leaf_count());
  const auto used = [&](std::uint32_t leaf) {
    return std::min(PhotonLeaf::kSize, size_ - leaf * PhotonLeaf::kSize);
  };
  parallel_for(execution, leaf_count(), 512, [&](std::size_t i) {
    PhotonLeaf& leaf = leaves_[i];
    const std::uint32_t count = used(static_cast<std::uint32_t>(i));
    // The photons lie where their paths left them: ask for those of a later leaf.
    const std::size_t ahead = std::min<std::size_t>((i + kAhead) * PhotonLeaf::kSize, size_ - count);
    for (std::uint32_t lane = 0; lane < count; ++lane) {
      const PhotonPlace& place = order[ahead + lane];
      __builtin_prefetch(&blocks[place.block][place.offset]);
    }
    for (std::uint32_t lane = 0; lane < count; ++lane) {
      const PhotonPlace& place = order[i * PhotonLeaf::kSize + lane];
      set(leaf, lane, blocks[place.block][place.offset], first[place.block] + place.offset);
      if (!etendues.empty()) etendues_[i][lane] = etendues[place.block][place.offset];
    }
    const Photon nowhere{.position = Vec3(kInfinity)};
    for (std::uint32_t lane = count; lane < PhotonLeaf::kSize; ++lane) set(leaf, lane, nowhere, 0);
    if (!etendues.empty()) std::fill(etendues_[i].begin() + count, etendues_[i].end(), 0.0f);
  });
  tree_ = BoxTree(leaf_count(), [&](std::uint32_t i) { return bounds_of(leaves_[i], used(i)); }, execution);
}

PhotonMap::PhotonMap(std::span<const Photon> photons, const Execution& execution)
    : PhotonMap(pieces(photons), execution) {}

std::optional<PhotonMap> PhotonMap::over(const Head& head, std::span<const PhotonLeaf> leaves,
                                         std::span<const PhotonLeaf::Lanes<float>> etendues,
                                         std::span<const std::byte> tree_nodes, std::shared_ptr<const void> owner) {
  PhotonMap map;
  map.size_ = head.size;
  map.grid_ = head.grid;
  auto tree = BoxTree::over(map.leaf_count(), tree_nodes, owner);
  if (leaves.size() != map.leaf_count() || !tree) return std::nullopt;
  if (!etendues.empty()) {
    if (etendues.size() != map.leaf_count()) return std::nullopt;
    map.etendues_ = view_large_array(etendues, owner);
  }
  map.leaves_ = view_large_array(leaves, std::move(owner));
  map.tree_ = std::move(*tree);
  return map;
}

std::uint32_t PhotonMap::near_leaf(const Vec3& p) const {
  const std::uint64_t code = grid_.code(p);
  const auto leaves = std::views::iota(1u, leaf_count());
  // The first leaf beyond, less one.
  const auto beyond = std::ranges::partition_point(
      leaves, [&](std::uint32_t i) { return grid_.code({leaves_[i].x[0], leaves_[i].y[0], leaves_[i].z[0]}) <= code; });
  return static_cast<std::uint32_t>(beyond - leaves.begin());
}

}  // namespace photond
