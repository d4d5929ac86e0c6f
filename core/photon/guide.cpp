#include "core/photon/guide.h"

namespace photond {

namespace {

constexpr std::uint32_t kPilotPass = 0xffffffff;   // a pass number no rendering reaches
constexpr std::uint32_t kPilotPhotons = 32'768;    // an eighth of a default pass

}  // namespace

Result<std::shared_ptr<const GatherGuide>> make_gather_guide(const PreparedScene& scene,
                                                             const PhotonSettings& photons,
                                                             const Execution& execution) {
  PhotonSettings pilot = photons;
  pilot.photons_per_pass = std::min(photons.photons_per_pass, kPilotPhotons);
  const auto maps = build_photon_maps(scene, {scene.digest, pilot, kPilotPass}, execution);
  if (!maps) return maps.error();
  const float growth = static_cast<float>(photons.photons_per_pass) / static_cast<float>(pilot.photons_per_pass);
  auto guide = std::make_shared<GatherGuide>();
  guide->pilot = *maps;
  guide->global = Bandwidth(*maps, &(*maps)->global, growth, execution);
  guide->caustic = Bandwidth(*maps, &(*maps)->caustic, growth, execution);
  guide->edges = Edges(scene.scene);
  if (execution.cancelled()) return cancelled();
  return std::shared_ptr<const GatherGuide>(std::move(guide));
}

}  // namespace photond
