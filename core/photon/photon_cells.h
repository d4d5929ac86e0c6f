#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/photon/morton_order.h"
#include "core/photon/photon.h"

namespace photond {

/// Photons on their way into a map, sorted into cells as they come, the cubes of a MortonGrid. Each cell gives its memory
/// back by itself: the map takes the photons' place instead of standing beside them.
class PhotonCells {
 public:
  /// The cells of a cube around `bounds`; photons outside belong to the nearest one.
  explicit PhotonCells(const Bounds3& bounds) : grid_(bounds) {}

  /// Copies the photons behind those that are there. For one thread at a time. Throws std::bad_alloc.
  void append(std::span<const Photon> photons);

  const MortonGrid& grid() const { return grid_; }
  /// The same grid where photons spread over half of it or more, else one around them: fine enough for where they are.
  MortonGrid fine_grid() const;

  /// Of all photons.
  std::uint64_t size() const { return size_; }
  std::uint64_t size(std::uint32_t cell) const { return cells_[cell].room - room_left(cell); }
  /// A cell's photons, in the order in which they came, in pieces of at most PhotonKey::kMaxSpan.
  std::vector<std::span<const Photon>> photons(std::uint32_t cell) const;
  /// Forgets them. For several threads at once, each with cells of its own.
  void free(std::uint32_t cell);

 private:
  static constexpr std::size_t kSlabBytes = std::size_t{1} << 22;
  // Slabs on large pages. Chunks of later ones are given back.
  static constexpr std::size_t kLargeSlabs = 16;
  // Cells have many small chunks where there are few photons: no more memory than those take.
  static constexpr std::size_t kSmallChunk = std::size_t{1} << 12, kLargeChunk = std::size_t{1} << 16;
  static_assert(kLargeChunk / sizeof(Photon) <= PhotonKey::kMaxSpan);

  struct Cell {
    std::vector<std::span<Photon>> chunks;   // all full but the last
    std::uint64_t room = 0;                  // photons in all chunks
  };
  struct Unmap {
    void operator()(std::byte* slab) const noexcept;
  };
  using Slab = std::unique_ptr<std::byte, Unmap>;

  std::byte* take_slab();
  std::span<Photon> take_chunk();
  void grow(std::uint32_t cell);
  std::uint64_t room_left(std::uint32_t cell) const { return static_cast<std::uint64_t>(end_[cell] - next_[cell]); }

  MortonGrid grid_;
  std::uint64_t size_ = 0;
  std::array<Cell, MortonGrid::kCubes> cells_;
  std::array<Photon*, MortonGrid::kCubes> next_{}, end_{};   // in each cell's last chunk
  std::vector<LargeArray<std::byte>> large_slabs_;
  std::vector<Slab> slabs_;
  std::byte* slab_ = nullptr;        // the last
  std::size_t taken_ = kSlabBytes;   // bytes of it
};

}  // namespace photond
