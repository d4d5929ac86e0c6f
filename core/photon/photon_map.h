#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/octahedral.h"
#include "core/photon/kd_tree.h"

namespace photond {

/// One hit of an emitted path: 32 bytes while it is stored.
struct Photon {
  Vec3 position{0};
  std::uint32_t direction = 0;   ///< octahedral: unit, away from the surface, where the photon came from
  std::uint32_t normal = 0;      ///< ten bits a component: geometric normal on the side the photon came from
  Rgb flux{0};                   ///< W, to be divided by the number of emitted paths
};

/// Photons with a spatial index. Immutable.
class PhotonMap {
 public:
  PhotonMap() = default;
  /// Indexes `photons`; the bits do not depend on the execution.
  PhotonMap(std::span<const Photon> photons, const Execution& execution);

  std::uint32_t size() const { return tree_.size(); }
  const KdTree& tree() const { return tree_; }
  Vec3 direction(std::uint32_t i) const { return decode_direction(payload_[i].direction); }
  Vec3 normal(std::uint32_t i) const { return decode_normal(payload_[i].normal); }
  const Rgb& flux(std::uint32_t i) const { return payload_[i].flux; }
  std::uint64_t memory_bytes() const { return tree_.memory_bytes() + payload_.capacity() * sizeof(Payload); }

 private:
  struct Payload {
    std::uint32_t direction;
    std::uint32_t normal;
    Rgb flux;
  };
  KdTree tree_;
  std::vector<Payload> payload_;   // in the tree's order
};

}  // namespace photond
