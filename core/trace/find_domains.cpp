#include "core/trace/find_domains.h"

#include <algorithm>
#include <bit>

#include "core/math/warp.h"
#include "core/trace/marked_square.h"

namespace photond {

namespace {

constexpr std::uint64_t kPilotPaths = 1024;
// Of these paths, and of the space of all: where more meet something, the whole is as good.
constexpr double kMostMeeting = 0.75;
constexpr double kMostShare = 0.85;
constexpr std::size_t kMaxEmitters = 1024;
constexpr std::uint32_t kAllCellBits = 20;    // of all emitters together
constexpr std::uint32_t kCellBits = 16;       // of one

// 1 where other lights are so much stronger that no path leaves a triangle.
double share_meeting(const Scene& scene, const Accel& accel, const Lights& lights) {
  const RngKey key(0, RngPurpose::pilot, 0);
  std::uint64_t paths = 0, meeting = 0;
  for (std::uint64_t i = 0; i < kPilotPaths; ++i) {
    Rng rng(key, i);
    const std::uint32_t light = lights.choose(rng.next());
    if (light >= lights.emitters().size()) continue;
    ++paths;
    meeting += accel.intersect(lights.sample_emission(scene, light, rng).ray).found();
  }
  return paths > 0 ? static_cast<double>(meeting) / static_cast<double>(paths) : 1;
}

// Directions are divided first: near lights are seldom so large that they look different from their parts.
EmissionDomain::Cells cells_of(std::size_t emitters, bool double_sided, bool evenly) {
  constexpr std::uint32_t kDirectionBits = 5;
  const auto counted = static_cast<std::uint32_t>(std::bit_width(emitters - 1));
  const std::uint32_t bits = std::min(kCellBits, kAllCellBits - counted) - (double_sided ? 1 : 0);
  const std::uint32_t directions = std::min(kDirectionBits, bits / 2);
  return {double_sided ? 2u : 1u, evenly ? bits / 2 - directions : 0, directions};
}

EmitterPiece piece_of(const EmitterTriangle& emitter, const EmissionDomain::Cells& cells, std::uint32_t side,
                      std::uint32_t place) {
  const std::uint32_t count = 1u << cells.place_bits;
  const Vec2 low = Vec2(place % count, place / count);
  const Vec3 normal = side == 0 ? emitter.normal : -emitter.normal;
  EmitterPiece piece{Vec3(0), 0, normal, kInfinity, emitter.extent};
  Vec3 corners[4];
  for (int i = 0; i < 4; ++i) {
    corners[i] = emitter.at(square_to_triangle((low + Vec2(i % 2, i / 2)) / static_cast<float>(count)));
    piece.middle += 0.25f * corners[i];
    piece.height = std::min(piece.height, glm::dot(corners[i], normal));
  }
  for (const Vec3& corner : corners) piece.radius = std::max(piece.radius, glm::distance(corner, piece.middle));
  return piece;
}

}  // namespace

EmissionDomain find_domain(const EmitterTriangle& emitter, bool double_sided, bool evenly, std::size_t count,
                           std::span<const SurfaceBox> boxes) {
  const EmissionDomain::Cells cells = cells_of(count, double_sided, evenly);
  std::vector<std::uint16_t> members;
  std::uint32_t cell = 0;
  for (std::uint32_t side = 0; side < cells.sides; ++side) {
    for (std::uint32_t place = 0; place < cells.places(); ++place) {
      const EmitterPiece piece = piece_of(emitter, cells, side, place);
      MarkedSquare square(cells.direction_bits);
      for (std::size_t i = 0; i < boxes.size() && !square.full(); ++i) square.mark(piece, boxes[i]);
      for (std::uint32_t y = 0; y < square.side(); ++y) {
        for (std::uint32_t x = 0; x < square.side(); ++x, ++cell) {
          if (square.marked(x, y)) members.push_back(static_cast<std::uint16_t>(cell));
        }
      }
    }
  }
  if (members.empty()) members.push_back(0);   // its paths meet nothing, but there are some
  return {cells, std::move(members)};
}

DomainFinding find_domains(const Scene& scene, const Bounds3& bounds, const Accel& accel, Lights& lights,
                           const Execution& execution) {
  DomainFinding finding;
  const std::span<const EmitterTriangle> emitters = lights.emitters();
  if (emitters.empty()) return finding;
  finding.emitters = true;
  finding.meeting = share_meeting(scene, accel, lights);
  if (finding.meeting > kMostMeeting || emitters.size() > kMaxEmitters) return finding;
  const std::vector<SurfaceBox> boxes = surface_boxes(scene, bounds);
  std::vector<EmissionDomain> domains(emitters.size());
  parallel_for(execution, emitters.size(), 1, [&](std::size_t i) {
    const bool double_sided = scene.materials[emitters[i].material].double_sided;
    const bool evenly = lights.shines_evenly(static_cast<std::uint32_t>(i));
    domains[i] = find_domain(emitters[i], double_sided, evenly, emitters.size(), boxes);
  });
  double chance = 0, share = 0;
  for (std::uint32_t i = 0; i < emitters.size(); ++i) {
    const auto probability = static_cast<double>(lights.probability(i));
    chance += probability;
    share += probability * static_cast<double>(domains[i].share());
  }
  finding.share = share / chance;
  finding.active = finding.share <= kMostShare;
  if (!finding.active) return finding;
  finding.effort = 1 - chance + share;
  lights.set_domains(scene, std::move(domains));
  return finding;
}

}  // namespace photond
