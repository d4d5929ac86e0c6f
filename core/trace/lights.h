#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/math/alias_table.h"
#include "core/math/lanes.h"
#include "core/math/rng.h"
#include "core/scene/scene.h"
#include "core/trace/aim.h"
#include "core/trace/box_lines.h"
#include "core/trace/emission_domain.h"
#include "core/trace/emission_pattern.h"
#include "core/trace/surface.h"

namespace photond {

/// One source of light that is chosen as a whole.
struct Light {
  enum class Kind : std::uint8_t { triangle, punctual, environment };
  Kind kind = Kind::triangle;
  std::uint32_t instance = 0;    ///< triangle
  std::uint32_t index = 0;       ///< triangle: into Mesh::triangles; punctual: into Scene::lights
};

/// A placed emissive triangle, origin + u·ab + v·ac, in one cache line.
struct alignas(64) EmitterTriangle {
  Vec3 origin;
  Vec3 ab;
  Vec3 ac;
  Vec3 normal;                   ///< unit, front
  float area;
  float extent;                  ///< largest |coordinate|, as SurfacePoint::extent
  float etendue;                 ///< of a path that leaves here: its flux for an emission of 1
  std::uint32_t material;

  Vec3 at(const Vec2& uv) const { return origin + uv.x * ab + uv.y * ac; }
};

/// A path leaving a light.
struct EmissionSample {
  Ray ray;
  Rgb flux{0};            ///< Le·cos/(P·pdf_a·pdf_w): what one path of one carries, in W
  float etendue = 0;      ///< flux/Le in m²·sr: the phase space that the path stands for; 0 of punctual lights;
                          ///< infinite of an environment whose light is left to paths
};

/// Paths that leave emissive triangles of one colour: uniform on the triangle, cosine-distributed or towards a ball.
struct alignas(64) EmissionLanes {
  // What comes in.
  Vec3Lanes origin, ab, ac, normal;  ///< the triangles; the normal on the side that emits, of paths that aim the front
  float extent[kLanes];
  float random[4][kLanes];           ///< of the place and the direction; of paths that aim, the same afterwards as if they
                                     ///< had left without
  std::uint32_t drawn[kLanes];       ///< the ball that is aimed at; kNone
  Vec3Lanes center;                  ///< of it; anything for none
  float radius[kLanes];

  // What goes out.
  Vec3Lanes flux;                ///< as in EmissionSample
  float etendue[kLanes];
  Vec3Lanes position;            ///< of the ray's origin
  Vec3Lanes direction;
  std::uint32_t back[kLanes];    ///< of those that aim: 1 where they leave the back, else 0

  /// From where and whereto the path of lane k leaves that aims.
  EmissionStart start(std::uint32_t k) const {
    return {{random[0][k], random[1][k]}, {random[2][k], random[3][k]}, back[k] != 0};
  }
  /// Computes the first `count` rays.
  void emit(std::uint32_t count);
  /// The path of lane k.
  EmissionSample sample(std::uint32_t k) const { return {{position[k], direction[k]}, flux[k], etendue[k]}; }

 private:
  void aim(std::uint32_t count);
};

/// Light arriving at a point from a sampled direction.
struct DirectSample {
  Vec3 wi{0};             ///< unit, from the point to the light
  Rgb radiance{0};        ///< divided by the density: L/pdf_w (area, environment) or I/(d² P) (punctual)
  float pdf_w = 0;        ///< per solid angle, light choice included; 0 for punctual lights
  float etendue = 0;      ///< as EmissionSample's of a path from there
  Vec3 target{0};         ///< where the shadow ray ends, safely off the light's surface
  bool infinite = false;  ///< the shadow ray has no end; `target` is unused
};

/// Points on emissive triangles of one colour, seen from several places.
struct alignas(64) DirectLanes {
  // What comes in.
  Vec3Lanes point;               ///< from where
  float random[2][kLanes];
  Vec3Lanes origin, ab, ac, normal;  ///< the triangles
  Vec3Lanes emission;
  float area[kLanes], probability[kLanes];   ///< of the triangle, and of its choice
  float extent[kLanes];
  float back[kLanes];            ///< 1 where both sides shine, else 0

  // What goes out, as in DirectSample.
  Vec3Lanes wi, radiance, target;
  float pdf_w[kLanes];
  std::uint32_t infinite[kLanes];

  /// Computes the first `count`.
  void sample(std::uint32_t count);
  /// Sets what goes out of lane k.
  void set(std::uint32_t k, const DirectSample& sample) {
    wi.set(k, sample.wi);
    radiance.set(k, sample.radiance);
    target.set(k, sample.target);
    pdf_w[k] = sample.pdf_w;
    infinite[k] = sample.infinite;
  }
};

/// Lights that belong together: the triangles of an emissive instance, or one other light.
struct LightGroup {
  std::uint32_t first = 0;
  std::uint32_t count = 1;
};

/// The emitters of a scene: chosen in proportion to the power that may meet it, with a floor that keeps dim lights alive.
/// Light from infinity, and from points and spots outside of the scene's bounding sphere, is emitted towards its bounds.
class Lights {
 public:
  Lights() = default;
  /// `bounds` are the world bounds of the scene.
  Lights(const Scene& scene, const Bounds3& bounds);

  bool empty() const { return lights_.empty(); }
  /// Of what belongs to each light; domains and aims are few.
  std::uint64_t memory_bytes() const;
  std::size_t size() const { return lights_.size(); }
  /// Sum of the lights' power in W, mean over RGB, of light from infinity what meets the bounds; exact but for emitters of
  /// textures or alpha (sampled) and environment maps (their mean for all directions).
  double total_power() const { return total_power_; }
  /// What photons' fluxes are told in, W: a power of two, 1 unless squares of fluxes in W might be no floats.
  float flux_unit() const { return flux_unit_; }

  /// A direction towards a light from `point`; black radiance where the light does not shine there. Visibility is
  /// not tested.
  DirectSample sample_direct(const Scene& scene, const Vec3& point, const Vec3& u) const;
  /// The same in lanes: fills what comes into `which` of them, but for the points and two of three random numbers, of
  /// which `u` is the last. Returns how many lanes are left out, since the light that is chosen is no triangle of one
  /// colour, and which ones.
  std::uint32_t begin_direct(const Scene& scene, std::span<const std::uint32_t> which, const float (&u)[kLanes],
                             DirectLanes& lanes, std::uint32_t (&others)[kLanes]) const;
  /// Density per solid angle with which `sample_direct` finds the emitter surface `s` from the origin of the ray of a
  /// unit direction that meets it after `distance`.
  float pdf_direct(const Scene& scene, const SurfacePoint& s, const Vec3& direction, float distance) const;
  /// The same for the environment in a direction.
  float pdf_environment(const Scene& scene, const Vec3& direction) const;

  /// EmissionSample::etendue of a path that leaves the emitter surface `s` in a direction: the inverse of the density
  /// with which `sample_emission` finds it, per area and projected solid angle. Infinite where `s` is not a light.
  float etendue(const Scene& scene, const SurfacePoint& s, const Vec3& direction) const;
  /// The same for a path from the environment that arrives at `point` from a direction with that `pdf_environment`.
  float environment_etendue(float pdf, const Vec3& point, const Vec3& from) const;
  /// Whether photons carry the environment's caustics (environment_casts). Where they do not, its étendues are infinite:
  /// paths take it all.
  bool environment_casts() const { return environment_casts_; }
  /// Whether any light has an étendue: whether paths that are traced from the eye can meet light at all.
  bool extended() const { return !emitters_.empty() || environment_ >= 0; }

  /// Starts a path. Black flux where the sampled point emits nothing.
  EmissionSample sample_emission(const Scene& scene, Rng& rng) const {
    return sample_emission(scene, choose(rng.next()), rng);
  }

  /// The same in two steps: which light, for u in [0, 1), and the path that leaves it.
  std::uint32_t choose(float u) const { return emission_choice_.sample(u); }
  /// The same among lights whose caustics photons carry. Not where casting_share() is 0.
  std::uint32_t choose_casting(float u) const { return leaves_out() ? casting_choice_.sample(u) : choose(u); }
  /// Probability with which `choose` returns one of those.
  double casting_share() const { return casting_share_; }
  /// What flux of a path is to be multiplied by where its light was drawn by choose_casting, and the number of paths
  /// divided by casting_share(): 1 but for rounding, so that the share of each light is exact.
  float casting_weight(std::uint32_t light) const {
    return leaves_out() ? static_cast<float>(emission_choice_.pdf(light) / (casting_share_ * casting_choice_.pdf(light))) : 1;
  }
  EmissionSample sample_emission(const Scene& scene, std::uint32_t light, Rng& rng) const {
    return sample_emission(scene, light, aim_of(light), rng);
  }
  /// The same as if the light had that aim.
  EmissionSample sample_emission(const Scene& scene, std::uint32_t light, const Aim& aim, Rng& rng) const;

  std::vector<LightGroup> groups() const;
  /// A place of the light, just off its front; nothing of light from infinity.
  std::optional<Vec3> place(const Scene& scene, std::uint32_t light) const;
  /// Probability with which `choose` returns the light.
  float probability(std::uint32_t light) const { return emission_choice_.pdf(light); }
  /// From now on the group's paths are emitted with that aim.
  void set_aim(const LightGroup& group, Aim aim);

  /// The emissive triangles, which are the first of the lights.
  std::span<const EmitterTriangle> emitters() const { return emitters_; }
  /// Whether places on that triangle are drawn evenly.
  bool shines_evenly(std::uint32_t light) const { return pattern_of(light).even(); }
  /// From now on paths leave emissive triangles from within these domains, one for each. Domains of triangles that do not
  /// shine evenly are not divided by place.
  void set_domains(const Scene& scene, std::vector<EmissionDomain> domains);
  /// What a path that leaves the light stands for beside what it carries, in terms of that: light that meets nothing.
  float unsent(std::uint32_t light) const { return 1 / sent_[light] - 1; }

  /// Asks the cache for a light.
  void prefetch(std::uint32_t light) const {
    if (light < emitters_.size()) __builtin_prefetch(&emitters_[light]);
  }
  /// Fills lane k of what comes into `lanes` with a path from the light, and of what goes out with what it carries if
  /// none aims. False, and nothing happens, unless the light is a triangle of one colour.
  bool begin_emission(const Scene& scene, std::uint32_t light, Rng& rng, std::uint32_t k, EmissionLanes& lanes) const;
  /// Where some of the light's paths aim: corrects what lane k carries, once its ray is known.
  void share_emission(const Scene& scene, std::uint32_t light, std::uint32_t k, EmissionLanes& lanes) const {
    if (aim_of(light).share() > 0) share_aimed(scene, light, k, lanes);
  }

 private:
  static constexpr std::uint32_t kNoLight = 0xffffffff;

  void add(const Light& light, double power, float sent = 1);
  float share_towards_bounds(const Vec3& point) const;
  void add_triangles(const Scene& scene, std::uint32_t instance);
  // What texture and alpha leave of the emission at a point of an emissive triangle, and the radiance that leaves it on
  // its front or back.
  Rgb emission_share(const Scene& scene, std::uint32_t index, const Vec2& uv) const;
  Rgb emitted(const Scene& scene, std::uint32_t index, const Vec2& uv, bool front) const;
  void set_etendues(const Scene& scene);
  // The places of an emitter are those of its mesh's triangle but for winding.
  Vec2 on_mesh(const Scene& scene, std::uint32_t light, const Vec2& uv) const;
  double power_per_radiance(const Scene& scene, std::uint32_t light) const;
  void measure_uneven(const Scene& scene);
  std::vector<float> look_at_cells(const Scene& scene, std::uint32_t light, std::uint32_t side,
                                   std::uint32_t per_cell) const;
  const EmissionPattern& pattern_of(std::uint32_t light) const {
    return patterns_[pattern_of_.empty() ? 0 : pattern_of_[light]];
  }
  float place_density(const Scene& scene, std::uint32_t light, const SurfacePoint& s) const;
  DirectSample sample_triangle(const Scene& scene, std::uint32_t light, const Vec3& point, const Vec2& u) const;
  const Aim& aim_of(std::uint32_t light) const { return aims_[aim_of_.empty() ? 0 : aim_of_[light]]; }
  void share_aimed(const Scene& scene, std::uint32_t light, std::uint32_t k, EmissionLanes& lanes) const;
  EmissionSample emit_triangle(const Scene& scene, std::uint32_t light, const Aim& aim, Rng& rng) const;
  // Whether photons leave the environment's caustics to paths.
  bool leaves_out() const { return environment_ >= 0 && !environment_casts_; }
  void set_emission_choice(std::span<const double> chances);
  EmissionSample emit_point(const PunctualLight& light, float choice, float sent, const Aim& aim, Rng& rng) const;
  const EmissionDomain& domain_of(const Scene& scene, std::uint32_t light) const;
  Ray ray_from_infinity(const Vec3& direction, const Aim& aim, Rng& rng, float& pdf_a) const;
  float triangle_etendue(std::uint32_t light, const Vec3& point, const Vec3& direction, const Aim& aim,
                         std::uint32_t drawn) const;
  float aimed_etendue(std::uint32_t light, const Vec3& point, const Vec3& direction, const Aim& aim,
                      std::uint32_t drawn) const;
  float line_pdf(const Vec3& point, const Vec3& direction, const Aim& aim, std::uint32_t drawn) const;

  // How far from a point or spot its light begins: a surface that it lies in, but for rounding, must not hide it. None
  // far outside, where a place itself is rounded by more.
  float clearance(const Vec3& position) const {
    return glm::distance(position, ball_.center) <= ball_.radius ? 0x1p-18f * ball_.radius : 0;
  }

  std::vector<Light> lights_;                     // triangles first
  std::vector<EmitterTriangle> emitters_;         // one for each of the triangles among lights_
  std::vector<double> powers_;                    // of each light, towards the scene
  std::vector<float> sent_;                       // share of its power that its paths carry
  AliasTable choice_;                             // for light that is sampled from where it arrives
  AliasTable emission_choice_;                    // for paths that leave lights
  AliasTable casting_choice_;                     // the same without the environment; empty where it is not left out
  double casting_share_ = 0;
  std::vector<EmissionPattern> patterns_ = {EmissionPattern()};   // the first is even
  std::vector<std::uint32_t> pattern_of_;         // for each emitter, into patterns_; empty where all are even
  std::vector<EmissionDomain> domains_;           // for each emitter; empty where all are whole
  std::vector<std::uint32_t> first_of_instance_;  // index of the light of an emissive instance's first triangle
  std::int64_t environment_ = -1;                 // index into lights_
  bool environment_casts_ = false;
  std::vector<Aim> aims_ = {Aim()};               // the first is none
  std::vector<std::uint32_t> aim_of_;             // for each light, into aims_; empty where none aims
  BoxLines bounds_;
  Ball ball_;                                     // around them
  double total_power_ = 0;
  float flux_unit_ = 1;
};

[[gnu::always_inline]] inline Rgb Lights::emitted(const Scene& scene, std::uint32_t index, const Vec2& uv, bool front) const {
  const Material& material = scene.materials[emitters_[index].material];
  if (!front && !material.double_sided) return Rgb(0);
  if (material.shines_evenly()) return material.emission;
  return material.emission * emission_share(scene, index, uv);
}

inline const EmissionDomain& Lights::domain_of(const Scene& scene, std::uint32_t light) const {
  static const EmissionDomain kWhole[2] = {EmissionDomain(1), EmissionDomain(2)};
  return domains_.empty() ? kWhole[scene.materials[emitters_[light].material].double_sided] : domains_[light];
}

[[gnu::always_inline]] inline float Lights::triangle_etendue(std::uint32_t light, const Vec3& point, const Vec3& direction,
                                                             const Aim& aim, std::uint32_t drawn) const {
  return aim.share() == 0 ? emitters_[light].etendue : aimed_etendue(light, point, direction, aim, drawn);
}

}  // namespace photond
