#pragma once

#include <cstdint>
#include <vector>

#include "core/math/rng.h"
#include "core/math/types.h"

namespace photond {

/// The numbers in [0, 1) from which a path leaves a light.
struct EmissionStart {
  Vec2 place{0};               ///< on a triangle
  Vec2 direction{0};           ///< on the hemisphere above it
  bool back = false;           ///< from the back of a triangle that shines on both sides
};

/// From where and whereto a light shines on anything: a part of the space of EmissionStart, made of equal cells. Paths
/// that leave it evenly, instead of the whole space, carry less each, and none is missed.
class EmissionDomain {
 public:
  /// How the space is divided: into 2^bits parts along each axis, 2^16 cells at most.
  struct Cells {
    std::uint32_t sides = 1;
    std::uint32_t place_bits = 0;
    std::uint32_t direction_bits = 0;

    std::uint32_t places() const { return 1u << (2 * place_bits); }
    std::uint32_t directions() const { return 1u << (2 * direction_bits); }
    std::uint32_t count() const { return sides * places() * directions(); }
  };

  /// The whole space, of one side or two.
  explicit EmissionDomain(std::uint32_t sides = 1) : cells_{sides, 0, 0} {}
  /// Some of the cells, by number: (side · places + place) · directions + direction, a place or a
  /// direction being y · 2^bits + x.
  EmissionDomain(const Cells& cells, std::vector<std::uint16_t> members);

  /// Its share of the space.
  float share() const { return share_; }
  bool whole() const { return members_.empty(); }
  bool contains(const EmissionStart& start) const;

  /// A start, uniform over the domain.
  EmissionStart draw(Rng& rng) const {
    EmissionStart start{rng.next2(), rng.next2()};
    if (!whole()) {
      narrow(start, rng.next_uint());
    } else if (cells_.sides == 2) {
      start.back = rng.next() >= 0.5f;
    }
    return start;
  }

 private:
  void narrow(EmissionStart& start, std::uint32_t choice) const;

  Cells cells_;
  std::vector<std::uint16_t> members_;   // empty: all
  std::vector<bool> is_member_;          // for each cell
  float share_ = 1;
};

}  // namespace photond
