#include "core/photon/photon_maps.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "core/photon/guide.h"
#include "core/photon/shoot.h"

namespace photond {

namespace {

// Paths of one task.
constexpr std::uint64_t kBlock = 2048;

constexpr std::uint32_t kIrradiancePass = 0xfffffffe;

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

// What a map is made of. Blocks are taken in their order, whoever computed them first, so that few are kept.
class Harvest {
 public:
  explicit Harvest(const Bounds3& bounds) : global(bounds), caustic(bounds) {}

  void add(std::size_t index, PhotonBlock block) {
    const std::lock_guard lock(mutex_);
    waiting_.emplace(index, std::move(block));
    for (auto it = waiting_.begin(); it != waiting_.end() && it->first == taken_; it = waiting_.erase(it), ++taken_) {
      take(it->second);
      spent_.push_back(std::move(it->second));
    }
  }

  // A block that was taken: to write into its memory costs less than into fresh.
  PhotonBlock spent() {
    const std::lock_guard lock(mutex_);
    if (spent_.empty()) return {};
    PhotonBlock block = std::move(spent_.back());
    spent_.pop_back();
    return block;
  }

  PhotonCells global, caustic;
  EnergyLedger ledger;
  std::uint64_t rays = 0, caustic_rays = 0;

 private:
  void take(const PhotonBlock& block) {
    global.append(block.global);
    caustic.append(block.caustic);
    photond::add(ledger, block.ledger);
    rays += block.rays;
    caustic_rays += block.caustic_rays;
  }

  std::mutex mutex_;
  std::map<std::size_t, PhotonBlock> waiting_;
  std::vector<PhotonBlock> spent_;
  std::size_t taken_ = 0;
};

}  // namespace

std::uint64_t paths_of_pass(const PreparedScene& scene, const PhotonSettings& settings) {
  const double asked = settings.photons_per_pass;
  return static_cast<std::uint64_t>(std::ceil(asked * scene.directed_share));
}

Result<std::shared_ptr<const PhotonMaps>> build_photon_maps(const PreparedScene& scene, const MapKey& key,
                                                            const Execution& execution) {
  if (is_irradiance_key(key)) {
    auto plain = build_photon_maps(scene, {key.scene, key.settings, 0}, execution);
    return plain ? add_irradiance(scene, key, *std::move(plain), execution) : plain;
  }
  const std::uint64_t paths = paths_of_pass(scene, key.settings);
  const std::uint64_t blocks = (paths + kBlock - 1) / kBlock;
  Harvest harvest(scene.bounds);
  std::atomic<std::uint64_t> next = 0;
  parallel_for(execution, blocks, 1, [&](std::size_t) {
    const std::uint64_t i = next++;   // a thread's own range would leave half of all blocks waiting
    const std::uint64_t end = std::min(paths, (i + 1) * kBlock);
    harvest.add(i, shoot(scene, key, i * kBlock, end, nullptr, harvest.spent()));
  });
  if (execution.cancelled()) return cancelled();

  auto maps = std::make_shared<PhotonMaps>();
  maps->emitted = static_cast<double>(paths);
  const double share = key.set == PhotonSet::caustic ? scene.lights.casting_share() : 1;
  if (share > 0) maps->emitted /= share;   // without such lights there are no photons
  maps->ledger = harvest.ledger;
  scale(maps->ledger, static_cast<double>(scene.lights.flux_unit()) / maps->emitted);
  maps->rays = harvest.rays;
  maps->caustic_rays = harvest.caustic_rays;
  maps->global = PhotonMap(std::move(harvest.global), false, execution);
  maps->caustic = PhotonMap(std::move(harvest.caustic), scene.lights.extended(), execution);
  if (execution.cancelled()) return cancelled();
  maps->memory_bytes = maps->global.memory_bytes() + maps->caustic.memory_bytes();
  return std::shared_ptr<const PhotonMaps>(std::move(maps));
}

MapKey irradiance_key(const Digest& scene, const PhotonSettings& photons) { return {scene, photons, kIrradiancePass}; }

bool is_irradiance_key(const MapKey& key) { return key.pass == kIrradiancePass; }

float widest_reach(const PreparedScene& scene) { return 0.1f * scene.bounds.radius(); }

Result<std::shared_ptr<const PhotonMaps>> add_irradiance(const PreparedScene& scene, const MapKey& key,
                                                         std::shared_ptr<const PhotonMaps> maps,
                                                         const Execution& execution) {
  const auto pilot = build_photon_maps(scene, guide_key(key.scene, key.settings), execution);
  if (!pilot) return pilot.error();
  auto result = std::make_shared<PhotonMaps>();
  result->global = maps->global.view(maps);
  result->caustic = maps->caustic.view(maps);
  const PhotonMap* const counted[] = {&maps->global, &maps->caustic};
  const PhotonMap* const at[] = {&(*pilot)->global, &(*pilot)->caustic};
  const double per_flux = maps->emitted / static_cast<double>(scene.lights.flux_unit());
  result->irradiance = Irradiance(counted, per_flux, at, Edges(scene.scene), widest_reach(scene), execution);
  if (execution.cancelled()) return cancelled();
  result->emitted = maps->emitted;
  result->rays = maps->rays;
  result->caustic_rays = maps->caustic_rays;
  result->ledger = maps->ledger;
  result->memory_bytes = maps->memory_bytes + result->irradiance.memory_bytes();
  return std::shared_ptr<const PhotonMaps>(std::move(result));
}

}  // namespace photond
