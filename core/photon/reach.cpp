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
  std::array<Vec2, Reach::kSectors> middle;   // of the sectors, unit
  std::array<float, Reach::kSectors> share;   // of the full angle
};

Vec2 diamond(float turn) {
  const float t = turn < 2 ? turn - 1 : 3 - turn;   // y in the diamond
  const float x = turn < 2 ? 1 - std::abs(t) : std::abs(t) - 1;
  return {x, t};
}

const Directions& directions() {
  static const Directions table = [] {
    Directions d;
    for (int i = 0; i < Reach::kSectors; ++i) {
      const float step = 4.0f / Reach::kSectors;
      const Vec2 begin = diamond(static_cast<float>(i) * step);
      const Vec2 end = diamond((static_cast<float>(i) + 1) * step);
      d.middle[i] = glm::normalize(diamond((static_cast<float>(i) + 0.5f) * step));
      const float angle = std::atan2(begin.x * end.y - begin.y * end.x, glm::dot(begin, end));
      d.share[i] = std::abs(angle) / (2 * kPi);
    }
    return d;
  }();
  return table;
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
    const float height = kMaxHeight * radius;
    if ((a.z > height && b.z > height) || (a.z < -height && b.z < -height)) return;
    // Only the part near the plane.
    const auto clip = [height](Vec3& from, const Vec3& to) {
      if (std::abs(from.z) <= height) return;
      const float target = from.z > 0 ? height : -height;
      from += (to - from) * ((target - from.z) / (to.z - from.z));
    };
    clip(a, b);
    clip(b, a);
    cut(a, b, radius * radius);
  });
}

void Reach::cut(const Vec3& a, const Vec3& b, float radius_sq) {
  const Directions& table = directions();
  const Vec2 p(a), q(b);
  const Vec2 along = q - p;
  const float moment = p.x * q.y - p.y * q.x;       // twice the area of the triangle with the center
  for (int i = 0; i < kSectors; ++i) {
    const Vec2& w = table.middle[i];
    // t·w = p + s·along
    const float determinant = w.x * along.y - w.y * along.x;
    if (determinant == 0) continue;
    const float t = moment / determinant;
    const float s = (p.x * w.y - p.y * w.x) / determinant;
    // An edge through the center itself does not tell which side of it is the surface: it cuts nothing.
    if (!(t > 0) || t * t >= radius_sq || s < 0 || s > 1) continue;
    reach_sq_[i] = std::min(reach_sq_[i], t * t);
    cut_ = true;
  }
}

float Reach::cut_coverage(float radius_sq) const {
  const Directions& table = directions();
  float sum = 0;
  for (int i = 0; i < kSectors; ++i) {
    const float s = std::min(reach_sq_[i] / radius_sq, 1.0f);
    sum += table.share[i] * (2 - s) * s;   // ∫₀^s 2(1 − s′) ds′
  }
  return std::max(sum, kMinCoverage);
}

}  // namespace photond
