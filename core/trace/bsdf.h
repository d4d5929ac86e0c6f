#pragma once

#include <cstdint>
#include <optional>

#include "core/base/features.h"
#include "core/math/frame.h"
#include "core/trace/clearcoat.h"
#include "core/trace/layer.h"
#include "core/trace/microfacet.h"
#include "core/trace/sheen.h"
#include "core/trace/surface.h"

namespace photond {

/// Parts of a BSDF; a technique may treat some of them and leave the others to another.
using LobeMask = std::uint8_t;
inline constexpr LobeMask kNoLobe = 0;
inline constexpr LobeMask kDiffuseLobe = 1;      ///< Lambert
inline constexpr LobeMask kReflectionLobe = 2;   ///< GGX or ideal reflection of metal and dielectric layer
inline constexpr LobeMask kGlassLobe = 4;        ///< dielectric reflection and transmission
inline constexpr LobeMask kClearcoatLobe = 8;    ///< GGX or ideal reflection of a clear coat
inline constexpr LobeMask kSheenLobe = 16;       ///< of fibres
inline constexpr LobeMask kAllLobes = 31;

/// What travels along the path: radiance from the camera side, or flux from the light side. Refraction scales
/// radiance by the square of the relative index, flux not at all.
enum class Transport : std::uint8_t { radiance, flux };

/// A sampled continuation.
struct BsdfSample {
  Vec3 wi{0};                ///< world, away from the surface
  Rgb weight{0};             ///< f·|cos θi| / pdf
  float pdf_w = 0;           ///< per solid angle, of the lobes sampled from; 0 for a delta lobe
  LobeMask lobe = kNoLobe;   ///< the lobe that was chosen
  bool delta = false;
  bool transmitted = false;  ///< wi is on the other geometric side
};

struct MaterialPoint;

/// The scattering of light at one surface point for a fixed direction `wo`, as glTF 2.0 defines it: a Lambert
/// base below a GGX layer of Schlick reflectance, mixed with a GGX metal and with a dielectric that transmits, all below
/// a sheen, and that below a clear coat. The base is scaled by what the layers let through both ways,
/// (1−E(i))(1−E(o))/(1−Ē), which equals glTF's (1−F) on average, is reciprocal and conserves energy exactly [Kelemen
/// and Szirmay-Kalos 2001]. Other lobes below a coat or a sheen are scaled by the lesser of what that lets through from
/// either direction: reciprocal, too, and no energy is gained. Transmission uses the exact Fresnel equations. Where a
/// delta lobe would send light through the surface to the wrong side, it takes the surface as flat.
class Bsdf {
 public:
  /// `wo`: unit, world, away from the surface, on the side of surface.ng.
  Bsdf(const Scene& scene, const SurfacePoint& surface, const Vec3& wo);

  /// The lobes that are not black.
  LobeMask lobes() const { return kAllFeatures ? lobes_ : kDiffuseLobe; }
  /// The lobes among them that are Dirac distributions.
  LobeMask delta_lobes() const {
    const LobeMask below = smooth() ? kReflectionLobe | kGlassLobe : kNoLobe;
    return lobes() & (coated() && coat_->smooth() ? below | kClearcoatLobe : below);
  }
  /// The reflections among them of a GGX α of at least `least`.
  LobeMask reflections_from(float least) const {
    const LobeMask rough = facets_.least() >= least ? kReflectionLobe : kNoLobe;
    return lobes() & (coated() && coat_->alpha() >= least ? rough | kClearcoatLobe : rough);
  }
  /// The shading normal of one lobe.
  const Vec3& normal(LobeMask lobe) const { return lobe == kClearcoatLobe ? coat_->normal() : frame_.n; }

  /// Whether a delta lobe is taken as flat.
  bool flat(LobeMask delta_lobe) const;
  /// The same where none is: about the shading normal, light may then go to the wrong side, where nothing is sampled.
  Bsdf about_shading_normal() const;
  /// The same where all are, and everything else is, too.
  Bsdf about_geometric_normal() const;
  /// The index beyond the surface over that on the side of wo, where light is bent.
  float bending_index() const { return (lobes() & kGlassLobe) != 0 && !thin_ ? eta_ : 1; }

  /// Probability with which `sample` reflects, rather than refracts, where all there is is smooth glass; 0 elsewhere.
  float smooth_glass_reflectance() const;

  /// Of light that arrives alike from everywhere, the share that the diffuse lobe sends towards `wo`, times π: what
  /// irradiance over π is to be multiplied by.
  Rgb diffuse_albedo() const;

  /// Probability with which `sample` chooses, of all lobes, one of `mask`.
  float share(LobeMask mask) const;

  /// f(wo, wi) in sr⁻¹ of the non-delta lobes in `mask`, without the cosine.
  Rgb eval(const Vec3& wi, LobeMask mask, Transport transport) const;
  /// Density per solid angle with which `sample` finds `wi` through the non-delta lobes in `mask`.
  float pdf(const Vec3& wi, LobeMask mask) const;
  /// Draws a direction from the lobes in `mask`; nothing where it is absorbed.
  std::optional<BsdfSample> sample(const Vec3& u, LobeMask mask, Transport transport) const;

 private:
  friend class Bsdf8;

  void set_facets(const Scene& scene, const SurfacePoint& surface, const MaterialPoint& p);
  void set_layer(const Rgb& f0, float f90);
  void set_selection();
  bool smooth() const { return facets_.least() < kSmoothAlpha; }
  bool coated() const { return kAllFeatures && coat_.has_value(); }
  bool sheened() const { return kAllFeatures && sheen_.has_value(); }
  bool coated_here() const { return coated() && !coat_->beyond(); }
  bool sheened_here() const { return sheened() && !sheen_->beyond(); }
  float through_tops() const;
  float through_tops(const Vec3& wi_local, const Vec3& wi) const;
  float mean_through() const;
  float mean_through(float cosine) const;
  float below_coat(const Vec3& wi, bool transmitted) const;
  float below_sheen(const Vec3& wi_local) const;
  float below_tops(const Vec3& wi_local, const Vec3& wi) const;
  float selection(LobeMask lobe, LobeMask mask) const;
  bool above(const Vec3& wi) const;
  bool same_side(const Vec3& wi_local, const Vec3& wi) const;
  bool same_side(const Vec3& wi_local) const { return same_side(wi_local, frame_.to_world(wi_local)); }

  Rgb reflection_fresnel(float cos_h) const;
  Rgb eval_reflection(const Vec3& wi) const;
  Rgb eval_glass(const Vec3& wi, Transport transport) const;
  float pdf_glass(const Vec3& wi) const;
  float glass_reflectance(float cos_h, float& cos_t) const;
  // What is kept of that: all where nothing can leave.
  Rgb glass_reflected(float cos_t) const { return cos_t > 0 ? glass_specular_ : Rgb(1); }

  // These fill in what their caller returns, and are false where nothing is scattered: copies of a sample made
  // member by member stall on their stores.
  bool sample_lobe(const Vec3& u, LobeMask mask, Transport transport, BsdfSample& out) const;
  bool sample_diffuse(const Vec2& u, LobeMask mask, Transport transport, BsdfSample& out) const;
  bool sample_reflection(const Vec2& u, LobeMask mask, Transport transport, BsdfSample& out) const;
  bool sample_glass(const Vec2& u, float choice, LobeMask mask, Transport transport, BsdfSample& out) const;
  bool sample_smooth_reflection(LobeMask mask, BsdfSample& out) const;
  bool sample_clearcoat(const Vec2& u, LobeMask mask, Transport transport, BsdfSample& out) const;
  bool sample_smooth_clearcoat(LobeMask mask, BsdfSample& out) const;
  bool sample_sheen(const Vec2& u, LobeMask mask, Transport transport, BsdfSample& out) const;
  bool sample_smooth_glass(float choice, LobeMask mask, Transport transport, BsdfSample& out) const;
  Vec3 glass_direction(const Vec3& h, float cos_h, float cos_t, bool reflected) const;
  bool finish(const Vec3& wi_local, LobeMask lobe, LobeMask mask, Transport transport, BsdfSample& out) const;

  Frame frame_;
  Vec3 ng_{0};
  Vec3 wo_{0};                 // local
  Rgb diffuse_{0};             // albedo of the base, already times (1−metallic)(1−transmission)
  Rgb f0_{0};                  // reflection lobe at normal and grazing incidence, metal and layer together
  Rgb f90_{0};
  Rgb glass_tint_{0};
  float glass_weight_ = 0;     // (1−metallic)·transmission
  Rgb glass_specular_{1};      // KHR_materials_specular's scaling of the dielectric reflection
  float eta_ = 1;              // index beyond the surface over the index on the side of wo
  Ggx facets_;
  Layer layer_;                // over the diffuse base
  float layer_out_ = 1;        // (1−E(o))/(1−Ē), of sheen and coat above as well
  float select_[5] = {0, 0, 0, 0, 0};  // relative selection probabilities of the lobes
  LobeMask lobes_ = kNoLobe;
  bool thin_ = true;
  bool may_flatten_ = true;
  std::optional<Clearcoat> coat_;
  std::optional<Sheen> sheen_;
};

}  // namespace photond
