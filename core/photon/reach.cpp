// Jones 1993: boundary correction of kernel estimates by cutting and renormalizing.
#include "core/photon/reach.h"

#include <algorithm>

namespace photond {

namespace {

// An edge so far off the tangent plane (in radii) ends another surface.
constexpr float kMaxHeight = 0.03f;
// A point in a narrow corner keeps little of its kernel: what remains is still divided by at least this share.
constexpr float kMinCoverage = 0.05f;

struct Directions {
  alignas(32) std::array<float, Reach::kSectors> x, y;   // of the sectors' middles, unit
  alignas(32) std::array<float, Reach::kSectors> share;  // of the full angle
};

Vec2 diamond(float turn) {
  const float t = turn < 2 ? turn - 1 : 3 - turn;   // y in the diamond
  const float x = turn < 2 ? 1 - std::abs(t) : std::abs(t) - 1;
  return {x, t};
}

Directions make_directions() {
  Directions d;
  for (std::uint32_t i = 0; i < Reach::kSectors; ++i) {
    const float step = 4.0f / Reach::kSectors;
    const Vec2 begin = diamond(static_cast<float>(i) * step);
    const Vec2 end = diamond((static_cast<float>(i) + 1) * step);
    const Vec2 middle = glm::normalize(diamond((static_cast<float>(i) + 0.5f) * step));
    d.x[i] = middle.x;
    d.y[i] = middle.y;
    const float angle = std::atan2(begin.x * end.y - begin.y * end.x, glm::dot(begin, end));
    d.share[i] = std::abs(angle) / (2 * kPi);
  }
  return d;
}

const Directions kDirections = make_directions();

// The part of a segment that is at most `height` off the plane z = 0; false where there is none.
bool clip(Vec3& a, Vec3& b, float height) {
  if ((a.z > height && b.z > height) || (a.z < -height && b.z < -height)) return false;
  const auto move = [height](Vec3& from, const Vec3& to) {
    if (std::abs(from.z) <= height) return;
    const float target = from.z > 0 ? height : -height;
    from += (to - from) * ((target - from.z) / (to.z - from.z));
  };
  move(a, b);
  move(b, a);
  return true;
}

}  // namespace

Reach::Reach(const Edges& edges, const Vec3& point, const Vec3& normal, float radius) {
  bool first = true;
  edges.near(point, radius, [&](const Edges::Segment& segment) {
    if (first) {
      frame_ = Frame(normal);
      reach_sq_.fill(kInfinity);
      first = false;
    }
    Vec3 a = frame_.to_local(segment.a - point);
    Vec3 b = frame_.to_local(segment.b - point);
    if (clip(a, b, kMaxHeight * radius)) cut(Vec2(a), Vec2(b), radius * radius);
  });
}

void Reach::cut(const Vec2& a, const Vec2& b, float radius_sq) {
  const Vec2 along = b - a;
  const float moment = a.x * b.y - a.y * b.x;       // twice the area of the triangle with the center
  Float8 nearest = Float8{} + nearest_sq_;
  for (std::uint32_t i = 0; i < kSectors; i += 8) {
    // t·(x, y) = a + s·along
    const Float8 x = load8(&kDirections.x[i]), y = load8(&kDirections.y[i]);
    const Float8 inverse = 1 / (x * along.y - y * along.x);
    const Float8 t = moment * inverse;
    const Float8 s = (a.x * y - a.y * x) * inverse;
    // An edge through the center itself does not tell which side of it is the surface: it cuts nothing. Nor does what
    // is not a number, where the edge runs along the direction.
    const Float8 t_sq = t * t;
    const Mask8 cuts = (t > 0) & (t_sq < radius_sq) & (s >= 0) & (s <= 1);
    const Float8 reach_sq = min8(cuts ? t_sq : Float8{} + kInfinity, load8(&reach_sq_[i]));
    store8(&reach_sq_[i], reach_sq);
    nearest = min8(nearest, reach_sq);
  }
  nearest_sq_ = least8(nearest);
}

float Reach::cut_coverage(float radius_sq) const {
  Float8 sum{};
  for (std::uint32_t i = 0; i < kSectors; i += 8) {
    const Float8 s = min8(load8(&reach_sq_[i]) / radius_sq, Float8{} + 1);
    sum += load8(&kDirections.share[i]) * (2 - s) * s;   // ∫₀^s 2(1 − s′) ds′
  }
  return std::max(sum8(sum), kMinCoverage);
}

}  // namespace photond
