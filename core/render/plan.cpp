#include "core/render/plan.h"

#include <algorithm>
#include <cstdio>

#include "core/photon/shoot.h"
#include "core/trace/casters.h"
#include "core/trace/dispersion.h"
#include "core/trace/medium.h"

namespace photond {

namespace {

struct Features {
  std::string caster;           // name of the first material that bundles light, with the reason
  bool absorption = false;
  bool alpha = false;
  bool anisotropy = false;
  bool clearcoat = false;
  std::string dispersing;      // name of the first material that disperses
  std::string frosted;         // of the first frosted glass
  bool casts = false;          // smooth glass, or a mirror
  bool nested = false;          // volumes within others
  bool sheen = false;
  bool bounded_light = false;   // any light but the environment
  bool surfaces = false;
  bool receivers = false;       // surfaces that gather photons
};

std::string label(const Material& material) {
  return material.name.empty() ? "an unnamed material" : "material '" + material.name + "'";
}

// "0.29 %", "3 %", "56 %"
std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, share < 0.0995 ? "%.2g %%" : "%.0f %%", 100 * share);
  return text;
}

// Whether photons may be gathered on it: neither clear glass nor polished metal all over, or below a sheen.
bool gathers(const Material& m) {
  if (m.sheened()) return true;
  if (m.transmission == 1 && !m.transmission_texture.used()) return false;
  if (m.clearcoat > 0 && (m.clearcoat_roughness_texture.used() || m.clearcoat_roughness * m.clearcoat_roughness >= kGatherAlpha)) {
    return true;
  }
  const bool metal = m.metallic == 1 && !m.metallic_roughness_texture.used();
  return !metal || m.roughness * m.roughness >= kGatherAlpha;
}

// Why light that it throws on others is found by chance only, or never; empty where it is not.
std::string casting(const Scene& scene, const Material& m) {
  if (casts_caustics(scene, m)) return label(m) + (m.transmission > 0 ? " transmits light" : " is a polished metal");
  if (!scene.lights.empty() && mirrors_points(scene, m)) return label(m) + " mirrors lights that are points";
  return {};
}

void note_material(const Scene& scene, const Material& m, Features& features) {
  if (features.caster.empty()) features.caster = casting(scene, m);
  features.absorption = features.absorption || Medium::absorbs(m);
  features.alpha = features.alpha || m.alpha_mode != AlphaMode::opaque;
  features.anisotropy = features.anisotropy || m.anisotropy > 0;
  features.clearcoat = features.clearcoat || m.clearcoat > 0;
  if (features.dispersing.empty() && disperses(m)) features.dispersing = label(m);
  if (features.frosted.empty() && frosts(m)) features.frosted = label(m);
  features.casts = features.casts || mirrors(scene, m);
  features.nested = features.nested || m.nested;
  features.sheen = features.sheen || m.sheened();
  features.bounded_light = features.bounded_light || m.emissive();
  features.receivers = features.receivers || gathers(m);
  features.surfaces = true;
}

Features find_features(const PreparedScene& prepared) {
  const Scene& scene = prepared.scene;
  Features features;
  features.receivers = prepared.shares_gloss;
  features.bounded_light = !scene.lights.empty();
  std::vector<bool> seen(scene.materials.size(), false);
  for (const Instance& instance : scene.instances) {
    const std::uint32_t material = scene.meshes[instance.mesh].material;
    if (!seen[material]) note_material(scene, scene.materials[material], features);
    seen[material] = true;
  }
  return features;
}

// What the scene lacks, so that nobody looks for the mistake in the picture.
void add_lacks(const Features& features, bool lit, std::vector<PlanItem>& items) {
  if (!lit) items.push_back({"light", false, "nothing shines: the picture is black"});
  if (!features.surfaces) items.push_back({"surfaces", false, "no surface: only light from infinity is seen"});
  if (features.surfaces && !features.receivers) {
    items.push_back({"receivers", false, "no surface gathers photons: all are clear glass or polished metal"});
  }
}

PlanItem environment_item(const PreparedScene& scene) {
  if (!scene.scene.environment.active()) return {"environment", false, "no environment"};
  return {"environment", true,
          scene.lights.environment_casts() ? "the scene is lit from around, so unevenly that it casts caustics"
                   : "the scene is lit from around, by light that paths find"};
}

PlanItem choose_method(const Features& features, bool sun, Method& method) {
  if (method != Method::automatic) return {"method", true, std::string(method_name(method)) + ": as asked"};
  method = Method::path;
  if (!features.bounded_light && !sun) {
    return {"method", true, "path: all light comes from the environment, which paths find"};
  }
  if (!features.receivers) return {"method", true, "path: there is no surface on which photons could be gathered"};
  method = Method::progressive;
  if (features.caster.empty()) {
    return {"method", true, "progressive: photons carry light between surfaces with less noise than paths"};
  }
  return {"method", true, "progressive: " + features.caster + ", and photons find the light behind it"};
}

PlanItem domain_item(const DomainFinding& domain, bool uses_maps) {
  const std::string text = percent(domain.meeting) + " of the paths that leave lamps meet a surface; " +
                           percent(domain.share) + " go where they may";
  return {"emission_domain", domain.active && uses_maps,
          !domain.emitters ? "no surface emits light"
          : !uses_maps     ? "the method stores no photons"
                           : text};
}

PlanItem pattern_item(const Lights& lights) {
  const std::size_t all = lights.emitters().size();
  std::size_t uneven = 0;
  for (std::uint32_t i = 0; i < all; ++i) uneven += lights.shines_evenly(i) ? 0 : 1;
  return {"emission_pattern", uneven > 0,
          all == 0      ? "no surface emits light"
          : uneven == 0 ? "triangles that emit light do so evenly"
                        : std::to_string(uneven) + " of " + std::to_string(all) +
                              " triangles that emit light do so unevenly: places on them are drawn where they are bright"};
}

PlanItem paths_item(double share, bool uses_maps) {
  const std::string text = "since paths are directed, " + percent(share) + " as many are traced in a pass";
  return {"fewer_paths", share < 1 && uses_maps,
          !uses_maps ? "the method stores no photons" : share < 1 ? text : "paths leave lights in all directions"};
}

PlanItem aim_item(const AimFinding& aim, bool uses_maps) {
  std::string text;
  if (aim.active) {
    text = percent(aim.share) + " of a light's paths are aimed at casters: " + percent(aim.aimed) +
           " of these reach photons' receivers by way of one, " + percent(aim.ordinary) + " of the others";
  } else {
    text = percent(aim.ordinary) + " of the ordinary paths of a light reach photons' receivers by way of a caster, " +
           percent(aim.aimed) + " of those aimed at it";
  }
  return {"aim_map", aim.active && uses_maps,
          !aim.casters   ? "no caster to aim at"
          : !aim.reached ? "no light reaches a receiver by way of a caster"
          : !uses_maps   ? "the method stores no photons"
                         : text};
}

// Where caustics are left to paths. `concentrated`: there is light that paths find by chance only.
std::string left_to_paths(const std::string& caster, bool concentrated) {
  const std::string reason = "the method stores no photons";
  if (!concentrated) return reason;
  return reason + "; " + caster + ": what paths have not found of that light is missing from the picture and from its error";
}

constexpr const char* kMissing = ": what comes to it from points is missing from the picture and from its error";

PlanItem gloss_item(const PreparedScene& scene, const Plan& plan) {
  const bool merges = plan.uses_maps && !plan.biased;
  const std::string left = std::string("the method leaves gloss to paths") + (scene.scene.lights.empty() ? "" : kMissing);
  return {"gloss_merge", scene.shares_gloss && merges,
          !scene.shares_gloss ? "no gloss is lit by way of glass or a mirror"
          : merges            ? "photons that come by way of glass or mirrors are gathered on gloss, too"
          : plan.uses_maps    ? left
                              : "the method stores no photons"};
}

// Light that comes to frosted glass by way of other glass or of mirrors: nothing is gathered there.
PlanItem frosted_item(const std::string& frosted, bool points) {
  if (frosted.empty()) return {"frosted_glass", false, "no frosted glass is lit by way of other glass or of mirrors"};
  return {"frosted_glass", true,
          frosted + " is frosted glass, lit by way of other glass or of mirrors, which is left to paths" +
              (points ? kMissing : "")};
}

PlanItem dispersion_item(const std::string& material, Method method) {
  if (material.empty()) return {"dispersion", false, "no material disperses light"};
  return {"dispersion", true, material + " disperses light: " +
                                  (method == Method::photon_map ? "a map holds light of three wavelengths only"
                                                                : "each pass traces three other wavelengths")};
}

PlanItem touching_item(std::size_t triangles) {
  return {"touching_glass", triangles > 0,
          triangles == 0 ? "no glass lies exactly on another surface"
                         : std::to_string(triangles) + " triangles of glass lie exactly on another surface, and are held apart: "
                           "by a gap, liquids and glass by an overlap"};
}

PlanItem shares_item(bool caustics, bool extended) {
  return {"mis_merge", caustics && extended,
          !caustics  ? "there are no caustics to share"
          : extended ? "photons and paths share caustics by how likely either is to find them"
                     : "lights are points: only photons find their caustics"};
}

// A radius beyond the scene spreads photons over nothing, and one that no photon will ever be within loses their light:
// the picture would be dark, and its estimate could not know.
Status check_radius(float radius, const Bounds3& bounds) {
  if (radius == 0 || bounds.empty()) return Done{};
  const float least = 1e-6f * bounds.radius(), most = 2 * bounds.radius();
  if (radius >= least && radius <= most) return Done{};
  char text[120];
  std::snprintf(text, sizeof text, "must be %.3g to %.3g metres in this scene, or 0 for automatic", least, most);
  return invalid_input(text, "/radius");
}

}  // namespace

Result<Plan> make_plan(const PreparedScene& scene, const RenderSettings& settings, const Execution& execution) {
  if (execution.cancelled()) return cancelled();
  if (const Status fine = check_radius(settings.radius, scene.bounds); !fine) return fine.error();
  const Features features = find_features(scene);
  Plan plan;
  plan.method = settings.method;
  plan.items.push_back(choose_method(features, scene.lights.environment_casts(), plan.method));
  plan.biased = plan.method == Method::photon_map;
  const bool concentrated = features.bounded_light || scene.lights.environment_casts();
  plan.uses_maps = plan.method == Method::photon_map || plan.method == Method::progressive ||
                   (plan.method == Method::hybrid && !features.caster.empty() && features.receivers && concentrated);

  const bool caustics = plan.uses_maps && !features.caster.empty();
  plan.items.push_back({"caustic_map", caustics,
                        features.caster.empty() ? "no material bundles light"
                        : plan.uses_maps        ? features.caster
                                                : left_to_paths(features.caster, concentrated)});
  if (plan.method == Method::hybrid) plan.items.push_back(shares_item(caustics, scene.lights.extended()));
  plan.items.push_back(gloss_item(scene, plan));
  plan.items.push_back(frosted_item(features.casts ? features.frosted : "", !scene.scene.lights.empty()));
  plan.items.push_back(domain_item(scene.domain, plan.uses_maps));
  plan.items.push_back(pattern_item(scene.lights));
  plan.items.push_back(aim_item(scene.aim, plan.uses_maps));
  plan.items.push_back(paths_item(scene.directed_share, plan.uses_maps));
  plan.items.push_back({"volume_absorption", features.absorption,
                        features.absorption ? "a transmitting volume has an attenuation colour"
                                            : "no volume absorbs light"});
  plan.items.push_back(dispersion_item(features.dispersing, plan.method));
  plan.items.push_back(touching_item(scene.touching_glass));
  plan.items.push_back({"nested_volumes", features.nested,
                        features.nested ? "volumes may reach into one another: paths know in which they are"
                                        : "no volume reaches into another"});
  plan.items.push_back({"alpha_test", features.alpha,
                        features.alpha ? "a material is masked or blended" : "every material is opaque"});
  plan.items.push_back({"anisotropy", features.anisotropy,
                        features.anisotropy ? "a material is brushed" : "no material is brushed"});
  plan.items.push_back({"clearcoat", features.clearcoat,
                        features.clearcoat ? "a material has a clear coat" : "no material has a clear coat"});
  plan.items.push_back({"sheen", features.sheen,
                        features.sheen ? "a material has a sheen" : "no material has a sheen"});
  plan.items.push_back(environment_item(scene));
  add_lacks(features, !scene.lights.empty(), plan.items);
  return plan;
}

}  // namespace photond
