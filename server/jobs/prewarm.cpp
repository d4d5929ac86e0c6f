#include "server/jobs/prewarm.h"

#include <exception>

#include "core/render/render.h"
#include "server/jobs/memory_need.h"

namespace photond {

std::vector<MapKey> prewarm_keys(const PrewarmSpec& spec, const Digest& content) {
  std::vector<MapKey> keys{guide_key(content, spec.photons)};
  const std::uint32_t maps = spec.method == Method::photon_map ? 1 : spec.passes;
  for (std::uint32_t pass = 0; pass < maps; ++pass) keys.push_back(map_key(content, spec.photons, spec.method, pass));
  return keys;
}

// What fails is not there, and the job that needs it tells why.
bool Prewarm::step() {
  bool more = false;
  try {
    more = advance().ok() && !missing_.empty();
  } catch (const std::exception&) {
    more = false;
  }
  if (!more) scene_.reset();
  ended_ = !more;
  return more;
}

Status Prewarm::advance() {
  if (execution_.cancelled()) return cancelled();
  if (!scene_) {
    auto scene = scenes_.prepared(spec_.scene, execution_);
    if (!scene) return scene.error();
    scene_ = std::move(*scene);
    return Done{};
  }
  const MapKey key = missing_.back();
  missing_.pop_back();
  const auto answer = maps_.get(*scene_, key, execution_, true);
  if (!answer) return answer.error();
  if (const auto& guide = answer->value->guide) {  // which comes first
    const MemoryNeed need{0, map_bytes(*scene_, *guide, spec_.photons, spec_.method)};
    if (const Status fits = check_memory(need, max_bytes_); !fits) return fits;
  }
  if (!execution_.cancelled()) return Done{};
  // It was done just then; whoever cancelled was told that there will be none.
  if (answer->origin == MapCache::Origin::built) maps_.erase(key);
  return cancelled();
}

}  // namespace photond
