#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "core/base/digest.h"
#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/photon/irradiance.h"
#include "core/photon/photon_map.h"
#include "core/photon/settings.h"
#include "core/trace/prepare.h"

namespace photond {

/// Names a set of photon maps by all they depend on beside the program (photon_stage). No camera, film or radius: those
/// reuse the maps. Nothing finer: photons that another intensity of a light or another material leaves as they are could
/// be told only by keeping each one's light and the materials of its path; but in all of seven test scenes photons
/// meet every material, and maps are 5 (pool) to 27 % (bulb) of a pass of 512 × 512 pixels. All lights at once are what
/// exposure is for.
struct MapKey {
  Digest scene;
  PhotonSettings settings;
  std::uint32_t pass = 0;
  PhotonSet set = PhotonSet::all;
  auto operator<=>(const MapKey&) const = default;
};

/// Names the maps of pass 0 with their irradiance: a pass number no rendering reaches.
MapKey irradiance_key(const Digest& scene, const PhotonSettings& photons);
bool is_irradiance_key(const MapKey& key);

/// The flux of one pass, in W per channel summed over RGB/3: emitted = absorbed + escaped + truncated + rejected.
struct EnergyLedger {
  double emitted = 0;
  double absorbed = 0;    ///< lost at surfaces and in media, Russian roulette's gains and losses included
  double escaped = 0;     ///< left the scene
  double truncated = 0;   ///< cut at the depth limit
  double rejected = 0;    ///< not finite or inconsistent with the geometric side
};

/// The photons of one pass and their indices. Immutable and independent of the camera.
struct PhotonMaps {
  PhotonMap global;        ///< indirect: at least one non-specular bounce before the stored hit
  PhotonMap caustic;       ///< light, then one or more specular bounces, then the stored hit: LS⁺D, and LS⁺ on gloss
                           ///< (PreparedScene::shares_gloss)
  Irradiance irradiance;   ///< by both maps; empty but where the key asks for it
  double emitted = 0;      ///< paths, with those of lights that were left out: photon powers, which are in Lights::flux_unit, are
                           ///< divided by it at the query
  std::uint64_t rays = 0;          ///< traced while shooting
  std::uint64_t caustic_rays = 0;  ///< of these, as many as PhotonSet::caustic alone needs
  EnergyLedger ledger;
  std::uint64_t memory_bytes = 0;
};

/// How many paths a pass traces: `photons_per_pass`, or fewer where they are directed (PreparedScene::directed_share).
std::uint64_t paths_of_pass(const PreparedScene& scene, const PhotonSettings& settings);

/// Emits the paths of a pass and indexes what they leave.
/// A pure function of scene and key: the bits do not depend on the execution. Errors: cancelled.
Result<std::shared_ptr<const PhotonMaps>> build_photon_maps(const PreparedScene& scene, const MapKey& key,
                                                            const Execution& execution);

/// What an irradiance_key names, from the maps of pass 0, whose memory it shares; at the places of the photons of a
/// guide's pilot. Errors: cancelled.
Result<std::shared_ptr<const PhotonMaps>> add_irradiance(const PreparedScene& scene, const MapKey& key,
                                                         std::shared_ptr<const PhotonMaps> maps,
                                                         const Execution& execution);

/// The distance within which photons are nearest ones: a search ends somewhere even where hardly any falls.
float widest_reach(const PreparedScene& scene);

/// Where a rendering gets the maps of a pass from: a cache, or build_photon_maps itself.
using MapSource = std::function<Result<std::shared_ptr<const PhotonMaps>>(const MapKey&, const Execution&)>;

}  // namespace photond
