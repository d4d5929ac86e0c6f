#include "core/trace/crossing_rays.h"

#include <array>

#include "core/math/float8.h"

namespace photond {

namespace {

using Byte8 = std::uint8_t __attribute__((vector_size(8)));

// For each set of eight lanes, its members one after the other.
constexpr auto kMembers = [] {
  std::array<std::array<std::uint8_t, 8>, 256> members{};
  for (std::uint32_t set = 0; set < 256; ++set) {
    for (std::uint8_t lane = 0, count = 0; lane < 8; ++lane) {
      if ((set >> lane & 1) != 0) members[set][count++] = lane;
    }
  }
  return members;
}();

[[gnu::always_inline]] inline Mask8 members_of(std::uint32_t set) {
  Byte8 members;
  std::memcpy(&members, kMembers[set].data(), sizeof members);
  return __builtin_convertvector(members, Mask8);
}

// Eight rays, each up to an end.
struct Rays8 {
  Vec3x8 origin, inverse;   // 1/direction
  Float8 end;

  [[gnu::always_inline]] Rays8(const Vec3x8& from, const Vec3x8& direction, const Float8& t_max)
      : origin(from), inverse{invert(direction.x), invert(direction.y), invert(direction.z)}, end(t_max) {}

  // Which of them cross the box.
  [[gnu::always_inline]] Mask8 cross(const Bounds3& box) const {
    constexpr float kRounding = 1 + 8 * 0x1p-23f;   // of the two distances
    Float8 near{}, far = end;
    cut(box.min.x, box.max.x, origin.x, inverse.x, near, far);
    cut(box.min.y, box.max.y, origin.y, inverse.y, near, far);
    cut(box.min.z, box.max.z, origin.z, inverse.z, near, far);
    return near <= far * kRounding;
  }
  // Any of them.
  [[gnu::always_inline]] Mask8 cross(const std::vector<Bounds3>& boxes) const {
    Mask8 any{};
    for (const Bounds3& box : boxes) any |= cross(box);
    return any;
  }

 private:
  [[gnu::always_inline]] static Float8 invert(const Float8& direction) {
    constexpr float kSmall = 1e-30f;   // instead of 0, by which 0 could not be divided
    return 1 / (direction >= 0 ? max8(direction, kSmall + Float8{}) : min8(direction, -kSmall + Float8{}));
  }
  // Leaves the part of a ray between two planes.
  [[gnu::always_inline]] static void cut(float min, float max, const Float8& from, const Float8& inverse, Float8& near,
                                         Float8& far) {
    const Float8 a = (min - from) * inverse, b = (max - from) * inverse;
    near = max8(near, min8(a, b));
    far = min8(far, max8(a, b));
  }
};

}  // namespace

CrossingRays::CrossingRays(const Cover& cover, const RayLanes& all, const float (&t_max)[kLanes], std::uint32_t count) {
  if (cover.whole.empty()) return;
  for (std::uint32_t first = 0; first < count; first += 8) {
    const Vec3x8 origin = load8(all.origin, first), direction = load8(all.direction, first);
    const Float8 end = load8(&t_max[first]);
    const Rays8 rays(origin, direction, end);
    const std::uint32_t there = count - first < 8 ? (1u << (count - first)) - 1 : 0xff;
    std::uint32_t set = bits8(rays.cross(cover.whole)) & there;
    if (set == 0) continue;
    if (!cover.parts.empty()) set &= bits8(rays.cross(cover.parts));
    const Mask8 order = members_of(set);
    store8(&rays_.origin.x[size_], __builtin_shuffle(origin.x, order));
    store8(&rays_.origin.y[size_], __builtin_shuffle(origin.y, order));
    store8(&rays_.origin.z[size_], __builtin_shuffle(origin.z, order));
    store8(&rays_.direction.x[size_], __builtin_shuffle(direction.x, order));
    store8(&rays_.direction.y[size_], __builtin_shuffle(direction.y, order));
    store8(&rays_.direction.z[size_], __builtin_shuffle(direction.z, order));
    store8(&rays_.t_max[size_], __builtin_shuffle(end, order));
    store8(&lane_[size_], order + static_cast<std::int32_t>(first));
    size_ += static_cast<std::uint32_t>(__builtin_popcount(set));
  }
}

void CrossingRays::put(const HitLanes& met, HitLanes& hits) const {
  for (std::uint32_t i = 0; i < size_; ++i) {
    if (met.instance[i] != Hit::kNone) hits.set(lane_[i], met[i]);
  }
}

void CrossingRays::put(const std::uint8_t (&met)[kLanes], std::uint8_t (&hidden)[kLanes]) const {
  for (std::uint32_t i = 0; i < size_; ++i) hidden[lane_[i]] = met[i];
}

}  // namespace photond
