#include "core/trace/emission_domain.h"

namespace photond {

EmissionDomain::EmissionDomain(const Cells& cells, std::vector<std::uint16_t> members)
    : cells_(cells),
      members_(std::move(members)),
      is_member_(cells.count(), false),
      share_(static_cast<float>(members_.size()) / static_cast<float>(cells.count())) {
  for (const std::uint16_t cell : members_) is_member_[cell] = true;
}

// From the whole space into the chosen cell.
void EmissionDomain::narrow(EmissionStart& start, std::uint32_t choice) const {
  const auto within = [](Vec2& u, std::uint32_t cell, std::uint32_t bits) {
    const std::uint32_t x = cell & ((1u << bits) - 1), y = cell >> bits;
    const float size = 1.0f / static_cast<float>(1u << bits);
    u = glm::min((Vec2(x, y) + u) * size, Vec2(0x1.fffffep-1f));   // 1 would be rounded up to
  };
  std::uint32_t cell = members_[(static_cast<std::uint64_t>(choice) * members_.size()) >> 32];
  within(start.direction, cell & (cells_.directions() - 1), cells_.direction_bits);
  cell >>= 2 * cells_.direction_bits;
  within(start.place, cell & (cells_.places() - 1), cells_.place_bits);
  start.back = cell >> (2 * cells_.place_bits) != 0;
}

bool EmissionDomain::contains(const EmissionStart& start) const {
  if (start.back && cells_.sides == 1) return false;
  if (whole()) return true;
  const auto cell = [](const Vec2& u, std::uint32_t bits) {
    const float side = static_cast<float>(1u << bits);
    const Vec2 at = glm::clamp(u * side, Vec2(0), Vec2(side - 1));
    return (static_cast<std::uint32_t>(at.y) << bits) + static_cast<std::uint32_t>(at.x);
  };
  const std::uint32_t place = start.back * cells_.places() + cell(start.place, cells_.place_bits);
  return is_member_[place * cells_.directions() + cell(start.direction, cells_.direction_bits)];
}

}  // namespace photond
