#include "core/trace/learn_aim.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/trace/casters.h"
#include "core/trace/gathered.h"
#include "core/trace/medium.h"
#include "core/trace/surface.h"

namespace photond {

namespace {

constexpr std::size_t kMaxBalls = 16;         // a path's density is a sum over all of them
constexpr std::size_t kMaxGroups = 64;
constexpr std::uint64_t kPilotPaths = 16'384; // of a scene; some ten milliseconds
constexpr std::uint64_t kMinPaths = 64;       // from a light to a ball
constexpr std::uint64_t kMaxPaths = 1024;
constexpr std::uint64_t kFluxPaths = 256;     // that tell what a light emits
constexpr int kMaxBounces = 16;

// Share of the paths that aim, and by how much more often than others they must bring light by way of a caster. What
// ordinary paths reach well is not worth the others' loss: where it was 10 times, errors grew by a quarter, where it was
// 24 times, they neither grew nor fell.
constexpr float kShare = 0.1f;
constexpr double kWorthwhile = 32;

double mean(const Rgb& c) { return (static_cast<double>(c.x) + c.y + c.z) / 3; }

// What pilot paths from a light to a ball bring.
struct Reached {
  double flux = 0;      // W by way of the ball to where photons are gathered
  double share = 0;     // of the paths
};

struct Pilot {
  const Scene& scene;
  const Accel& accel;
  const Lights& lights;

  // Flux where the path is gathered after bounces that are not; 0 where it ends otherwise.
  double landing(const EmissionSample& emission, Rng& rng) const {
    Ray ray = emission.ray;
    Rgb flux = emission.flux;
    Medium medium;
    if (is_black(flux)) return 0;
    for (int bounce = 0; bounce < kMaxBounces; ++bounce) {
      const Hit hit = accel.intersect(ray);
      if (!hit.found()) return 0;
      const SurfacePoint surface = make_surface(scene, ray, hit);
      flux *= medium.transmittance(surface, hit.t);
      const Bsdf bsdf(scene, surface, -ray.direction);
      const LobeMask gathered = gathered_lobes(bsdf);
      if (bounce > 0 && gathered != kNoLobe) return mean(flux);
      const Vec2 u = rng.next2();
      const auto sample = bsdf.sample({u, rng.next()}, kAllLobes, Transport::flux);
      if (!sample || (sample->lobe & gathered) != 0) return 0;
      flux *= sample->weight;
      medium.cross(surface, *sample);
      ray = spawn_ray(surface, sample->wi);
    }
    return 0;
  }

  // A light of the group in proportion to its chance; `chance`: of all of them.
  std::uint32_t choose(const LightGroup& group, double chance, double u) const {
    double left = u * chance;
    for (std::uint32_t i = group.first; i + 1 < group.first + group.count; ++i) {
      left -= static_cast<double>(lights.probability(i));
      if (left < 0) return i;
    }
    return group.first + group.count - 1;
  }

  // Mean of `value` over paths of the group that have the aim, as flux in W.
  template <class Value>
  void emit(const LightGroup& group, const Aim& aim, std::uint64_t stream, std::uint64_t paths, const Value& value) const {
    double chance = 0;
    for (std::uint32_t i = 0; i < group.count; ++i) chance += static_cast<double>(lights.probability(group.first + i));
    const RngKey key(0, RngPurpose::pilot, stream);
    for (std::uint64_t i = 0; i < paths; ++i) {
      Rng rng(key, i);
      const double stratified = (static_cast<double>(i) + static_cast<double>(rng.next())) / static_cast<double>(paths);
      const EmissionSample sample = lights.sample_emission(scene, choose(group, chance, stratified), aim, rng);
      value(sample, rng, chance / static_cast<double>(paths));
    }
  }

  double flux(const LightGroup& group, std::uint64_t stream) const {
    double sum = 0;
    emit(group, Aim(), stream, kFluxPaths,
         [&](const EmissionSample& sample, Rng&, double factor) { sum += factor * mean(sample.flux); });
    return sum;
  }

  Reached reach(const LightGroup& group, const Ball& ball, std::uint64_t stream, std::uint64_t paths) const {
    Reached reached;
    static constexpr double kOne[] = {1};
    emit(group, Aim({&ball, 1}, kOne, 1), stream, paths, [&](const EmissionSample& sample, Rng& rng, double factor) {
      const double landed = landing(sample, rng);
      if (!(landed > 0) || !std::isfinite(landed)) return;
      reached.flux += factor * landed;
      reached.share += 1 / static_cast<double>(paths);
    });
    return reached;
  }
};

// The strongest groups.
std::vector<LightGroup> pilot_groups(const Lights& lights) {
  std::vector<LightGroup> groups = lights.groups();
  const auto chance = [&](const LightGroup& group) {
    double sum = 0;
    for (std::uint32_t i = 0; i < group.count; ++i) sum += static_cast<double>(lights.probability(group.first + i));
    return sum;
  };
  std::stable_sort(groups.begin(), groups.end(),
                   [&](const LightGroup& a, const LightGroup& b) { return chance(a) > chance(b); });
  if (groups.size() > kMaxGroups) groups.resize(kMaxGroups);
  return groups;
}

// The balls that ordinary emission reaches most seldom for what they are worth, as long as all of them together still
// are: weights of the balls, and what ordinary and aimed paths bring of them.
struct Choice {
  std::vector<double> weights;
  double ordinary = 0;
  double aimed = 0;
  double gain() const { return ordinary > 0 ? aimed / ordinary : 0; }
};

Choice choose_balls(std::span<const Reached> reached, double flux) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (reached[i].flux > 0) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double x = reached[a].flux * reached[b].share, y = reached[b].flux * reached[a].share;
    return x != y ? x < y : a < b;
  });
  Choice best;
  std::vector<double> weights(reached.size(), 0);
  double ordinary = 0, aimed = 0, sum = 0;
  for (const std::size_t i : order) {
    // By the root of what they bring: faint caustics are seen, too.
    weights[i] = std::sqrt(reached[i].flux);
    sum += weights[i];
    aimed += weights[i] * reached[i].share;
    ordinary += std::min(reached[i].flux / flux, 1.0);
    const Choice choice{weights, ordinary, aimed / sum};
    if (best.ordinary == 0 || choice.gain() >= kWorthwhile) best = choice;
  }
  return best;
}

}  // namespace

AimFinding learn_aim(const Scene& scene, const Accel& accel, Lights& lights, const Execution& execution) {
  AimFinding finding;
  if (lights.empty()) return finding;
  const std::vector<Ball> balls = caster_balls(scene, kMaxBalls);
  finding.casters = !balls.empty();
  if (balls.empty()) return finding;
  const std::vector<LightGroup> groups = pilot_groups(lights);
  const std::size_t pairs = groups.size() * balls.size();
  const std::uint64_t paths = std::clamp(kPilotPaths / pairs, kMinPaths, kMaxPaths);
  const Pilot pilot{scene, accel, lights};
  std::vector<Reached> reached(pairs);
  parallel_for(execution, pairs, 1, [&](std::size_t i) {
    reached[i] = pilot.reach(groups[i / balls.size()], balls[i % balls.size()], i, paths);
  });
  double best = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const auto of_group = std::span(reached).subspan(g * balls.size(), balls.size());
    const Choice choice = choose_balls(of_group, pilot.flux(groups[g], pairs + g));
    if (!(choice.ordinary > 0)) continue;
    finding.reached = true;
    if (choice.gain() > best) {
      best = choice.gain();
      finding.ordinary = choice.ordinary;
      finding.aimed = choice.aimed;
    }
    if (choice.gain() < kWorthwhile) continue;
    finding.active = true;
    std::vector<Ball> aims;
    std::vector<double> weights;
    for (std::size_t b = 0; b < balls.size(); ++b) {
      if (choice.weights[b] > 0) aims.push_back(balls[b]), weights.push_back(choice.weights[b]);
    }
    lights.set_aim(groups[g], Aim(aims, weights, kShare));
  }
  return finding;
}

}  // namespace photond
