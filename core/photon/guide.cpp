#include "core/photon/guide.h"

#include <algorithm>

namespace photond {

namespace {

constexpr std::uint32_t kPilotPass = 0xffffffff;   // a pass number no rendering reaches
constexpr std::uint32_t kPilotPhotons = 32'768;    // an eighth of a default pass

}  // namespace

MapKey guide_key(const Digest& scene, const PhotonSettings& photons) {
  PhotonSettings pilot = photons;
  pilot.photons_per_pass = std::min(photons.photons_per_pass, kPilotPhotons);
  return {scene, pilot, kPilotPass};
}

bool is_guide_key(const MapKey& key) { return key.pass == kPilotPass; }

float pilot_share(const PhotonSettings& photons) {
  return static_cast<float>(std::min(photons.photons_per_pass, kPilotPhotons)) /
         static_cast<float>(photons.photons_per_pass);
}

Result<std::shared_ptr<const GatherGuide>> build_gather_guide(const PreparedScene& scene, const MapKey& key,
                                                              const Execution& execution) {
  const auto pilot = build_photon_maps(scene, key, execution);
  if (!pilot) return pilot.error();
  auto guide = std::make_shared<GatherGuide>();
  guide->pilot = *pilot;
  guide->global = Bandwidth(*pilot, &(*pilot)->global, execution);
  guide->caustic = Bandwidth(*pilot, &(*pilot)->caustic, execution);
  guide->edges = Edges(scene.scene);
  if (execution.cancelled()) return cancelled();
  guide->memory_bytes = (*pilot)->memory_bytes + guide->global.densities().size_bytes() +
                        guide->caustic.densities().size_bytes() + guide->edges.memory_bytes();
  return std::shared_ptr<const GatherGuide>(std::move(guide));
}

}  // namespace photond
