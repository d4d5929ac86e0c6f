#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/photon/photon_maps.h"

namespace photond {

/// `content-photons-seed-pass`, with `-caustic` behind it for PhotonSet::caustic, the content being the scene's digest
/// without cameras and names: the name of photon maps in URLs and of their files.
std::string key_text(const MapKey& key);
/// The key of such a text; nothing where it is not exactly that.
std::optional<MapKey> parse_key(std::string_view text);

}  // namespace photond
