#include "core/photon/photon_cells.h"

#include <new>

#include <sys/mman.h>

#include "core/photon/photon_lanes.h"

namespace photond {

void PhotonCells::Unmap::operator()(std::byte* slab) const noexcept { munmap(slab, kSlabBytes); }

std::byte* PhotonCells::take_slab() {
  if (large_slabs_.size() < kLargeSlabs) return large_slabs_.emplace_back(make_large_array<std::byte>(kSlabBytes)).get();
  void* slab = mmap(nullptr, kSlabBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (slab == MAP_FAILED) throw std::bad_alloc();
  return slabs_.emplace_back(static_cast<std::byte*>(slab)).get();
}

std::span<Photon> PhotonCells::take_chunk() {
  if (taken_ == kSlabBytes) {
    slab_ = take_slab();
    taken_ = 0;
  }
  std::byte* chunk = slab_ + taken_;
  const std::size_t bytes = slabs_.empty() ? kSmallChunk : kLargeChunk;
  taken_ += bytes;
  return {reinterpret_cast<Photon*>(chunk), bytes / sizeof(Photon)};
}

void PhotonCells::grow(std::uint32_t cell) {
  const auto chunk = cells_[cell].chunks.emplace_back(take_chunk());
  cells_[cell].room += chunk.size();
  next_[cell] = chunk.data();
  end_[cell] = chunk.data() + chunk.size();
}

void PhotonCells::append(std::span<const Photon> photons) {
  constexpr std::ptrdiff_t kAhead = 64 / sizeof(Photon);
  for_parts(photons, grid_, 0, [&](const Photon& photon, std::uint32_t part) {
    const std::uint32_t cell = part >> (MortonGrid::kPartBits - MortonGrid::kCubeBits);
    if (next_[cell] == end_[cell]) grow(cell);
    copy(photon, *next_[cell]++);
    __builtin_prefetch(next_[cell] + kAhead, 1);   // the cell's next line, when others have pushed it out of the cache
  });
  size_ += photons.size();
}

MortonGrid PhotonCells::fine_grid() const {
  Bounds3 taken;   // cells
  for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
    if (size(cell) > 0) taken.add(MortonGrid::cube_position(cell));
  }
  if (taken.empty() || max_component(taken.extent()) >= 3) return grid_;
  Bounds3 bounds;
  for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
    for (const auto& span : photons(cell)) {
      for (const Photon& photon : span) bounds.add(photon.position);
    }
  }
  return MortonGrid(bounds);
}

std::vector<std::span<const Photon>> PhotonCells::photons(std::uint32_t cell) const {
  std::vector<std::span<const Photon>> spans(cells_[cell].chunks.begin(), cells_[cell].chunks.end());
  if (!spans.empty()) spans.back() = {spans.back().data(), next_[cell]};
  return spans;
}

void PhotonCells::free(std::uint32_t cell) {
  for (const auto& chunk : cells_[cell].chunks) {
    // Private memory always takes this advice.
    if (chunk.size_bytes() > kSmallChunk) (void)madvise(chunk.data(), kLargeChunk, MADV_DONTNEED);
  }
  cells_[cell] = {};
  next_[cell] = end_[cell] = nullptr;
}

}  // namespace photond
