#include "core/photon/photon_map.h"

namespace photond {

PhotonMap::PhotonMap(std::span<const Photon> photons, const Execution& execution) : payload_(photons.size()) {
  std::vector<Vec3> positions(photons.size());
  parallel_for(execution, photons.size(), 4096, [&](std::size_t i) { positions[i] = photons[i].position; });
  std::vector<std::uint32_t> order;
  tree_ = KdTree::build(positions, execution, order);
  parallel_for(execution, photons.size(), 4096, [&](std::size_t i) {
    const Photon& photon = photons[order[i]];
    payload_[i] = {photon.direction, photon.normal, photon.flux};
  });
}

}  // namespace photond
