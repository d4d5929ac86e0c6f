#pragma once

#include <cstdint>
#include <span>

#include "core/math/octahedral.h"
#include "core/photon/box_tree.h"
#include "core/photon/packed_flux.h"
#include "core/photon/photon_cells.h"

namespace photond {

/// Eight photons that are neighbours along the Morton curve, component by component, so that they are tested and
/// summed together: 26 bytes a photon. Places left over in the last leaf hold photons at infinity.
struct PhotonLeaf {
  static constexpr std::uint32_t kSize = 8;
  template <class T>
  using Lanes = std::array<T, kSize>;

  Lanes<float> x, y, z;
  Lanes<std::uint32_t> normal;                    ///< as Photon::normal
  std::array<Lanes<std::uint16_t>, 3> flux;       ///< as encode_flux, channel by channel
  Lanes<std::uint32_t> direction;                 ///< as Photon::direction

  Lanes<float> distances_sq(const Vec3& center) const {
    Lanes<float> d;
    for (std::uint32_t i = 0; i < kSize; ++i) d[i] = length_sq(x[i] - center.x, y[i] - center.y, z[i] - center.z);
    return d;
  }
};

/// Photons with a spatial index: 29.5 bytes a photon, 33.5 with étendues. Immutable.
class PhotonMap {
 public:
  /// In which photons lie: by their cells, and within a cell along a Morton curve as fine as all photons allow.
  struct Order {
    MortonGrid cells, fine;
  };

  PhotonMap() = default;
  /// Indexes photons, with or without their étendues, and gives their memory back on the way, all but the first 64 MB:
  /// 20 million photons become a map within 1 GB. The bits do not depend on the execution. Undefined once that is
  /// cancelled.
  PhotonMap(PhotonCells cells, bool etendues, const Execution& execution);
  /// Of photons that stay where they are, without étendues.
  PhotonMap(std::span<const Photon> photons, const Execution& execution);

  std::uint32_t size() const { return size_; }
  const BoxTree& tree() const { return tree_; }
  std::uint32_t leaf_count() const {
    return static_cast<std::uint32_t>((std::uint64_t{size_} + PhotonLeaf::kSize - 1) / PhotonLeaf::kSize);
  }
  const PhotonLeaf& leaf(std::uint32_t i) const { return leaves_[i]; }
  std::span<const PhotonLeaf> leaves() const { return {leaves_.get(), leaf_count()}; }

  /// Of the photons of leaf i; only where has_etendues().
  const PhotonLeaf::Lanes<float>& etendues(std::uint32_t i) const { return etendues_[i]; }
  bool has_etendues() const { return etendues_ != nullptr; }
  /// Of all leaves; empty where there are none.
  std::span<const PhotonLeaf::Lanes<float>> etendues() const {
    return {etendues_.get(), has_etendues() ? leaf_count() : 0};
  }

  /// The leaf that holds the place of `p` in their order. There must be photons.
  std::uint32_t near_leaf(const Vec3& p) const;

  /// Photon i = 0 … size−1 is photon i mod 8 of leaf i/8.
  Vec3 position(std::uint32_t i) const { return {of(i).x[lane(i)], of(i).y[lane(i)], of(i).z[lane(i)]}; }
  Vec3 direction(std::uint32_t i) const { return decode_direction(of(i).direction[lane(i)]); }
  Vec3 normal(std::uint32_t i) const { return decode_normal(normal_bits(i)); }
  std::uint32_t normal_bits(std::uint32_t i) const { return of(i).normal[lane(i)]; }
  /// W, to be divided by the number of emitted paths; rounded without bias to 1/256.
  Rgb flux(std::uint32_t i) const {
    const auto channel = [&](int c) { return decode_flux(of(i).flux[c][lane(i)]); };
    return {channel(0), channel(1), channel(2)};
  }
  /// What a map is beside its leaves and its tree.
  struct Head {
    std::uint32_t size = 0;
    Order order;
  };
  Head head() const { return {size_, order_}; }
  /// Of what another map has told; it uses leaves, étendues and tree where they lie. Nothing where they do not belong
  /// together.
  static std::optional<PhotonMap> over(const Head& head, std::span<const PhotonLeaf> leaves,
                                       std::span<const PhotonLeaf::Lanes<float>> etendues,
                                       std::span<const std::byte> tree_nodes, std::shared_ptr<const void> owner);

  /// The same map, which uses the memory of this one where it lies.
  PhotonMap view(std::shared_ptr<const void> owner) const {
    return *over(head(), leaves(), etendues(), tree().nodes(), std::move(owner));
  }

  std::uint64_t memory_bytes() const { return tree_.memory_bytes() + leaf_count() * leaf_bytes(); }

 private:
  // Photons of one cell, which are numbered from `first` on in the map.
  void take(PhotonSpans photons, std::uint32_t first, const Execution& execution);
  void set(std::uint32_t i, const Photon& photon);
  void set_leaf(std::uint32_t i, const std::array<const Photon*, PhotonLeaf::kSize>& photons);
  void bound_leaf_of(std::uint32_t i);

  const PhotonLeaf& of(std::uint32_t i) const { return leaves_[i / PhotonLeaf::kSize]; }
  static std::uint32_t lane(std::uint32_t i) { return i % PhotonLeaf::kSize; }

  std::size_t leaf_bytes() const {
    return sizeof(PhotonLeaf) + (has_etendues() ? sizeof(PhotonLeaf::Lanes<float>) : 0);
  }

  std::uint32_t size_ = 0;
  Order order_;
  LargeArray<PhotonLeaf> leaves_;
  LargeArray<PhotonLeaf::Lanes<float>> etendues_;
  BoxTree tree_;
};

}  // namespace photond
