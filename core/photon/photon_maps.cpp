#include "core/photon/photon_maps.h"

#include <algorithm>

#include "core/photon/shoot.h"

namespace photond {

namespace {

// Paths of one task; the blocks are joined in order, whoever computed them.
constexpr std::uint64_t kBlock = 2048;

void add(EnergyLedger& sum, const EnergyLedger& part) {
  sum.emitted += part.emitted;
  sum.absorbed += part.absorbed;
  sum.escaped += part.escaped;
  sum.truncated += part.truncated;
  sum.rejected += part.rejected;
}

void scale(EnergyLedger& ledger, double factor) {
  for (double* part : {&ledger.emitted, &ledger.absorbed, &ledger.escaped, &ledger.truncated, &ledger.rejected}) {
    *part *= factor;
  }
}

template <class T>
std::vector<std::span<const T>> parts(const std::vector<PhotonBlock>& blocks, std::vector<T> PhotonBlock::*part) {
  std::vector<std::span<const T>> spans;
  for (const PhotonBlock& block : blocks) spans.emplace_back(block.*part);
  return spans;
}

}  // namespace

Result<std::shared_ptr<const PhotonMaps>> build_photon_maps(const PreparedScene& scene, const MapKey& key,
                                                            const Execution& execution) {
  const std::uint64_t paths = key.settings.photons_per_pass;
  std::vector<PhotonBlock> blocks((paths + kBlock - 1) / kBlock);
  parallel_for(execution, blocks.size(), 1, [&](std::size_t i) {
    blocks[i] = shoot(scene, key, i * kBlock, std::min(paths, (i + 1) * kBlock));
  });
  if (execution.cancelled()) return cancelled();

  auto maps = std::make_shared<PhotonMaps>();
  maps->emitted = static_cast<double>(paths);
  if (key.set == PhotonSet::caustic) maps->emitted /= std::max(scene.lights.casting_share(), 1e-6);
  for (const PhotonBlock& block : blocks) {
    add(maps->ledger, block.ledger);
    maps->rays += block.rays;
    maps->caustic_rays += block.caustic_rays;
  }
  scale(maps->ledger, 1 / maps->emitted);
  maps->global = PhotonMap(parts(blocks, &PhotonBlock::global), execution);
  std::vector<std::span<const float>> etendues;
  if (scene.lights.extended()) etendues = parts(blocks, &PhotonBlock::caustic_etendue);
  maps->caustic = PhotonMap(parts(blocks, &PhotonBlock::caustic), etendues, execution);
  if (execution.cancelled()) return cancelled();
  maps->memory_bytes = maps->global.memory_bytes() + maps->caustic.memory_bytes();
  return std::shared_ptr<const PhotonMaps>(std::move(maps));
}

}  // namespace photond
