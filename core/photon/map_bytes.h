#pragma once

#include <memory>

#include "core/base/sections.h"
#include "core/photon/guide.h"
#include "core/photon/photon_maps.h"

namespace photond {

/// The identity of a file that holds what `key` names: its photon maps, or the guide where it is a guide's key. Other
/// keys, other photon stages and other versions of this format have others.
Digest map_identity(const MapKey& key);

/// What a file tells of itself beside what is used.
struct MapFacts {
  std::uint32_t global = 0;    ///< photons
  std::uint32_t caustic = 0;
  double build_seconds = 0;
};

/// The first bytes of a file from which read_facts tells.
inline constexpr std::size_t kFactsBytes = 568;
/// The facts of a file that begins with `first_bytes`; nothing where it is not one of this key and photon stage. What
/// follows is not looked at, so the file may be damaged.
std::optional<MapFacts> read_facts(std::span<const std::byte> first_bytes, const MapKey& key);

/// A file of photon maps. The list refers to `maps`.
SectionList map_sections(const PhotonMaps& maps, double build_seconds);
/// The photon maps of a file, which uses its bytes where they lie. Null where the bytes are not such a file, whole and
/// undamaged, of this key and of this photon stage.
std::shared_ptr<const PhotonMaps> read_photon_maps(SharedSpan file, const MapKey& key, const Execution& execution);

/// The same of guides.
SectionList guide_sections(const GatherGuide& guide, double build_seconds);
std::shared_ptr<const GatherGuide> read_gather_guide(SharedSpan file, const MapKey& key, const Execution& execution);

}  // namespace photond
