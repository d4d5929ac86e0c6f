#include "core/photon/photon_map.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <ranges>
#include <vector>

#include "core/photon/photon_lanes.h"

namespace photond {

namespace {

template <class Lanes>
[[gnu::always_inline]] inline void store(Lanes& lanes, const Mask8& v) {
  static_assert(sizeof lanes == sizeof v);
  std::memcpy(&lanes, &v, sizeof v);
}

[[gnu::always_inline]] inline void store_low(PhotonLeaf::Lanes<std::uint16_t>& lanes, const Mask8& v) {
  using Half8 = std::uint16_t __attribute__((vector_size(16)));
  const Half8 low = __builtin_convertvector(v, Half8);
  std::memcpy(&lanes, &low, sizeof low);
}

Bounds3 bounds_of(const PhotonLeaf& leaf, std::uint32_t count) {
  Bounds3 bounds;
  for (std::uint32_t i = 0; i < count; ++i) bounds.add({leaf.x[i], leaf.y[i], leaf.z[i]});
  return bounds;
}

// Photons of a task.
constexpr std::size_t kPiece = 16'384;

PhotonCells cells_of(std::span<const Photon> photons) {
  Bounds3 bounds;
  for (const Photon& photon : photons) bounds.add(photon.position);
  PhotonCells cells(bounds);
  cells.append(photons);
  return cells;
}

}  // namespace

PhotonMap::PhotonMap(PhotonCells cells, bool etendues, const Execution& execution)
    : size_(static_cast<std::uint32_t>(cells.size())), order_{cells.grid(), cells.fine_grid()} {
  leaves_ = make_large_array<PhotonLeaf>(leaf_count());
  if (etendues) etendues_ = make_large_array<PhotonLeaf::Lanes<float>>(leaf_count());
  tree_ = BoxTree(leaf_count());
  std::array<std::uint32_t, MortonGrid::kCubes> first;
  std::uint64_t n = 0;
  for (std::uint32_t cell = 0; cell < first.size(); ++cell) {
    first[cell] = static_cast<std::uint32_t>(n);
    n += cells.size(cell);
  }
  parallel_for(execution, first.size(), 1, [&](std::size_t i) {
    const auto cell = static_cast<std::uint32_t>(i);
    const std::uint64_t count = cells.size(cell);
    if (count == 0) return;
    take(cells.photons(cell), first[cell], count > kPiece ? execution : Execution{nullptr, execution.stop});
    cells.free(cell);
  });
  for (std::uint32_t i = size_; i < leaf_count() * PhotonLeaf::kSize; ++i) set(i, {.position = Vec3(kInfinity)});
  for (std::uint32_t cell = 0; cell < first.size(); ++cell) {
    const std::uint32_t end = cell + 1 < first.size() ? first[cell + 1] : size_;
    for (std::uint32_t i = first[cell]; i < end; i += kPiece) bound_leaf_of(i);
    if (end > 0) bound_leaf_of(end - 1);
  }
  tree_.close(execution);
}

PhotonMap::PhotonMap(std::span<const Photon> photons, const Execution& execution)
    : PhotonMap(cells_of(photons), false, execution) {}

void PhotonMap::take(PhotonSpans photons, std::uint32_t first, const Execution& execution) {
  const int levels = order_.fine == order_.cells ? MortonGrid::kCubeLevels : 0;
  const auto order = morton_order(photons, order_.fine, levels, execution);
  if (execution.cancelled()) return;   // there is no order
  std::size_t n = 0;
  for (const auto& span : photons) n += span.size();
  parallel_for(execution, (n + kPiece - 1) / kPiece, 1, [&](std::size_t piece) {
    const std::size_t end = std::min(n, (piece + 1) * kPiece);
    for (std::size_t i = piece * kPiece; i < end;) {
      const auto to = first + static_cast<std::uint32_t>(i);
      if (lane(to) != 0 || end - i < PhotonLeaf::kSize) {
        set(to, order[i++].of(photons));
        continue;
      }
      std::array<const Photon*, PhotonLeaf::kSize> eight;
      for (const Photon*& photon : eight) photon = &order[i++].of(photons);
      set_leaf(to / PhotonLeaf::kSize, eight);
    }
  });
}

void PhotonMap::set(std::uint32_t i, const Photon& photon) {
  PhotonLeaf& leaf = leaves_[i / PhotonLeaf::kSize];
  const std::uint32_t k = lane(i);
  leaf.x[k] = photon.position.x;
  leaf.y[k] = photon.position.y;
  leaf.z[k] = photon.position.z;
  leaf.normal[k] = photon.normal;
  leaf.direction[k] = photon.direction;
  for (int c = 0; c < 3; ++c) leaf.flux[c][k] = photon.flux[c];
  if (has_etendues()) etendues_[i / PhotonLeaf::kSize][k] = photon.etendue;
}

// Where several pieces share a leaf.
void PhotonMap::bound_leaf_of(std::uint32_t i) {
  const std::uint32_t leaf = i / PhotonLeaf::kSize;
  tree_.set(leaf, bounds_of(leaves_[leaf], std::min(PhotonLeaf::kSize, size_ - leaf * PhotonLeaf::kSize)));
}

void PhotonMap::set_leaf(std::uint32_t i, const std::array<const Photon*, PhotonLeaf::kSize>& photons) {
  const std::array<Mask8, 8> m = transposed(photons);
  PhotonLeaf& leaf = leaves_[i];
  store(leaf.x, m[0]);
  store(leaf.y, m[1]);
  store(leaf.z, m[2]);
  store(leaf.direction, m[3]);
  store(leaf.normal, m[4]);
  store_low(leaf.flux[0], m[5]);
  store_low(leaf.flux[1], m[5] >> 16);
  store_low(leaf.flux[2], m[6]);
  if (has_etendues()) store(etendues_[i], m[7]);
  const auto coordinates = [&](int axis) { return reinterpret_cast<const Float8&>(m[axis]); };
  const Vec3x8 points{coordinates(0), coordinates(1), coordinates(2)};
  tree_.set(i, bounds8(points, points));
}

std::optional<PhotonMap> PhotonMap::over(const Head& head, std::span<const PhotonLeaf> leaves,
                                         std::span<const PhotonLeaf::Lanes<float>> etendues,
                                         std::span<const std::byte> tree_nodes, std::shared_ptr<const void> owner) {
  PhotonMap map;
  map.size_ = head.size;
  map.order_ = head.order;
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
  const std::uint32_t cell = order_.cells.cube(p);
  const std::uint64_t code = order_.fine.code(p);
  const auto leaves = std::views::iota(1u, leaf_count());
  // The first leaf beyond, less one.
  const auto beyond = std::ranges::partition_point(leaves, [&](std::uint32_t i) {
    const Vec3 start = position(i * PhotonLeaf::kSize);
    const std::uint32_t its_cell = order_.cells.cube(start);
    return its_cell < cell || (its_cell == cell && order_.fine.code(start) <= code);
  });
  return static_cast<std::uint32_t>(beyond - leaves.begin());
}

}  // namespace photond
