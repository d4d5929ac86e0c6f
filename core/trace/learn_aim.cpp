#include "core/trace/learn_aim.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/trace/casters.h"
#include "core/trace/gathered.h"
#include "core/trace/medium.h"
#include "core/trace/roulette.h"
#include "core/trace/surface.h"

namespace photond {

namespace {

constexpr std::size_t kMaxBalls = 16;         // a path's density is a sum over all of them
constexpr std::size_t kMaxGroups = 64;
constexpr std::uint64_t kPilotPaths = 16'384; // of a scene; some ten milliseconds
constexpr std::uint64_t kMinPaths = 64;       // from a light to a ball
constexpr std::uint64_t kMaxPaths = 1024;
constexpr std::uint64_t kMinOrdinary = 256;   // ordinary paths from a light
constexpr std::uint64_t kMaxOrdinary = 4096;
constexpr std::uint32_t kMaxBounces = 16;

// Paths that bring light by way of a caster so much more often than others are worth a share of all, however much else
// those bring: errors are greatest where light arrives seldom. Where it was 24 times, errors neither grew nor fell.
constexpr double kSeldom = 32;
constexpr double kShare = 0.1;
// Otherwise a share pays where it makes the variance so much smaller.
constexpr double kWorthwhile = 1.25;
constexpr double kMostShare = 0.9;

double mean(const Rgb& c) { return (static_cast<double>(c.x) + c.y + c.z) / 3; }

// What ordinary paths from a light bring.
struct Ordinary {
  double flux = 0;       // W that they carry
  double scattered = 0;  // photons a path leaves where it comes from surfaces that scattered it
};

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
    for (std::uint32_t bounce = 0; bounce < kMaxBounces; ++bounce) {
      const Hit hit = accel.intersect(ray);
      if (!hit.found()) return 0;
      SurfacePoint surface = make_surface(scene, ray, hit);
      flux *= medium.transmittance(scene, surface, hit.t);
      surface.ior = medium.relative_index(scene, surface);
      const Bsdf bsdf(scene, surface, -ray.direction);
      const LobeMask gathered = gathered_lobes(bsdf);
      if (bounce > 0 && gathered != kNoLobe) return mean(flux);
      const Vec2 u = rng.next2();
      auto sample = bsdf.sample({u, rng.next()}, kAllLobes, Transport::flux);
      if (!sample || settle_gathered(bsdf, gathered, rng, *sample)) return 0;
      flux *= sample->weight;
      medium.cross(scene, surface, sample->transmitted);
      ray = spawn_ray(surface, sample->wi);
    }
    return 0;
  }

  // Photons that the path leaves after it has been scattered.
  double scattered(const EmissionSample& emission, Rng& rng) const {
    Ray ray = emission.ray;
    bool has_been = false;
    double photons = 0;
    for (std::uint32_t bounce = 0; bounce < kMaxBounces; ++bounce) {
      const Hit hit = accel.intersect(ray);
      if (!hit.found()) return photons;
      const SurfacePoint surface = make_surface(scene, ray, hit);
      const Bsdf bsdf(scene, surface, -ray.direction);
      const LobeMask gathered = gathered_lobes(bsdf);
      photons += has_been && gathered != kNoLobe;
      const Vec2 u = rng.next2();
      auto sample = bsdf.sample({u, rng.next()}, kAllLobes, Transport::flux);
      const bool by_gathered = sample && settle_gathered(bsdf, gathered, rng, *sample);
      if (!sample || rng.next() >= survival_probability(max_component(sample->weight), bounce)) return photons;
      has_been = has_been || by_gathered;
      ray = spawn_ray(surface, sample->wi);
    }
    return photons;
  }

  // Probability with which a path leaves a light of the group.
  double chance(const LightGroup& group) const {
    double sum = 0;
    for (std::uint32_t i = 0; i < group.count; ++i) sum += static_cast<double>(lights.probability(group.first + i));
    return sum;
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
    const double chance = this->chance(group);
    const RngKey key(0, RngPurpose::pilot, stream);
    for (std::uint64_t i = 0; i < paths; ++i) {
      Rng rng(key, i);
      const double stratified = (static_cast<double>(i) + static_cast<double>(rng.next())) / static_cast<double>(paths);
      const EmissionSample sample = lights.sample_emission(scene, choose(group, chance, stratified), aim, rng);
      value(sample, rng, chance / static_cast<double>(paths));
    }
  }

  Ordinary ordinary(const LightGroup& group, std::uint64_t stream, std::uint64_t paths) const {
    Ordinary sum;
    double photons = 1;   // one more than are seen: what none of these paths finds may be there, too
    emit(group, Aim(), stream, paths, [&](const EmissionSample& sample, Rng& rng, double factor) {
      sum.flux += factor * mean(sample.flux);
      photons += scattered(sample, rng);
    });
    sum.scattered = photons / static_cast<double>(paths);
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
std::vector<LightGroup> pilot_groups(const Pilot& pilot) {
  std::vector<LightGroup> groups = pilot.lights.groups();
  std::ranges::stable_sort(groups, std::ranges::greater{}, [&](const LightGroup& group) { return pilot.chance(group); });
  if (groups.size() > kMaxGroups) groups.resize(kMaxGroups);
  return groups;
}

// Balls to aim at: their weights, what ordinary and aimed paths bring by way of them, and the share of paths that aims.
struct Choice {
  std::vector<double> weights;
  double ordinary = 0;
  double aimed = 0;
  double share = 0;
  double effort = 1;        // as AimFinding's
  double gain() const { return ordinary > 0 ? aimed / ordinary : 0; }
};

// Variance of an estimate of what comes by way of the balls and of what is scattered elsewhere, both from so many
// photons as the share leaves, in units of that of one photon.
double variance(const Choice& choice, double scattered) {
  const double reached = choice.ordinary + (choice.aimed - choice.ordinary) * choice.share;
  return choice.ordinary * choice.ordinary / reached + scattered / (1 - choice.share);
}

// The share for which that is least.
double best_share(const Choice& choice, double scattered) {
  const double more = choice.aimed - choice.ordinary;
  if (!(more > 0)) return 0;
  const double k = std::sqrt(scattered / more) / choice.ordinary;
  return std::clamp((1 - k * choice.ordinary) / (1 + k * more), 0.0, kMostShare);
}

// The balls that ordinary emission reaches most seldom for what they are worth: as many as leave the least variance, but
// rather as many as it reaches very seldom, if any.
Choice choose_balls(std::span<const Reached> reached, const Ordinary& paths) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (reached[i].flux > 0) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double x = reached[a].flux * reached[b].share, y = reached[b].flux * reached[a].share;
    return x != y ? x < y : a < b;
  });
  Choice best, seldom;
  double most_saved = 0;
  std::vector<double> weights(reached.size(), 0);
  double ordinary = 0, aimed = 0, sum = 0;
  for (const std::size_t i : order) {
    // By the root of what they bring: faint caustics are seen, too.
    weights[i] = std::sqrt(reached[i].flux);
    sum += weights[i];
    aimed += weights[i] * reached[i].share;
    ordinary += std::min(reached[i].flux / paths.flux, 1.0);
    Choice choice{weights, ordinary, aimed / sum, 0};
    const double all = variance(choice, paths.scattered);
    choice.share = best_share(choice, paths.scattered);
    const double left = variance(choice, paths.scattered);
    choice.effort = left / all;
    if (all < kWorthwhile * left) choice.share = 0, choice.effort = 1;
    if (best.ordinary == 0 || (choice.share > 0 && all - left > most_saved)) {
      best = choice;
      most_saved = choice.share > 0 ? all - left : 0;
    }
    choice.share = std::max(choice.share, kShare);
    if (choice.gain() >= kSeldom) seldom = choice;
  }
  return seldom.ordinary > 0 ? seldom : best;
}

}  // namespace

AimFinding learn_aim(const Scene& scene, const Accel& accel, Lights& lights, const Execution& execution) {
  AimFinding finding;
  if (lights.empty()) return finding;
  const std::vector<Ball> balls = caster_balls(scene, kMaxBalls);
  finding.casters = !balls.empty();
  if (balls.empty()) return finding;
  const Pilot pilot{scene, accel, lights};
  const std::vector<LightGroup> groups = pilot_groups(pilot);
  const std::size_t pairs = groups.size() * balls.size();
  const std::uint64_t paths = std::clamp(kPilotPaths / pairs, kMinPaths, kMaxPaths);
  const std::uint64_t ordinary_paths = std::clamp(kPilotPaths / groups.size(), kMinOrdinary, kMaxOrdinary);
  std::vector<Reached> reached(pairs);
  parallel_for(execution, pairs, 1, [&](std::size_t i) {
    reached[i] = pilot.reach(groups[i / balls.size()], balls[i % balls.size()], i, paths);
  });
  std::vector<Choice> choices(groups.size());
  parallel_for(execution, groups.size(), 1, [&](std::size_t g) {
    const auto of_group = std::span(reached).subspan(g * balls.size(), balls.size());
    if (std::ranges::all_of(of_group, [](const Reached& r) { return !(r.flux > 0); })) return;
    choices[g] = choose_balls(of_group, pilot.ordinary(groups[g], pairs + g, ordinary_paths));
  });
  const Choice* best = &choices.front();
  for (const Choice& choice : choices) {
    if (std::pair(choice.share > 0, choice.gain()) > std::pair(best->share > 0, best->gain())) best = &choice;
  }
  finding.reached = best->ordinary > 0;
  finding.ordinary = best->ordinary;
  finding.aimed = best->aimed;
  finding.share = best->share;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const Choice& choice = choices[g];
    if (!(choice.share > 0)) continue;
    finding.active = true;
    finding.effort -= pilot.chance(groups[g]) * (1 - choice.effort);
    std::vector<Ball> aims;
    std::vector<double> weights;
    for (std::size_t b = 0; b < balls.size(); ++b) {
      if (choice.weights[b] > 0) aims.push_back(balls[b]), weights.push_back(choice.weights[b]);
    }
    lights.set_aim(groups[g], Aim(aims, weights, static_cast<float>(choice.share)));
  }
  return finding;
}

}  // namespace photond
