#pragma once

#include <cstdint>

#include "core/base/result.h"
#include "core/render/render.h"

namespace photond {

/// What the picture of a job takes at its peak, in bytes a pixel: mean, variance and squared bias in doubles, as much
/// again to filter them, the picture and its error in floats.
inline constexpr std::uint64_t kPictureBytes = 6 * sizeof(glm::dvec3) + 4 * sizeof(Rgb);

/// What a job takes in memory at its peak beside its scene, as far as is known before anything of it is computed.
struct MemoryNeed {
  std::uint64_t film = 0;  ///< bytes, with a picture while it is made
  std::uint64_t maps = 0;  ///< bytes of the photon maps of one pass
};

/// Bytes that the film of such a job keeps between passes, at most.
std::uint64_t film_memory(const RenderSettings& settings);
/// By the settings alone: the film as it is from the second block of passes on, and one photon of each path where the
/// method is sure to store them.
MemoryNeed memory_need(const RenderSettings& settings, const PhotonSettings& photons);
/// By the photons that the task's pilot map has; more than that, of the settings of the whole job.
MemoryNeed memory_need(const RenderTask& task, const RenderSettings& settings);
/// Of the photon maps of a method that gathers alone, by their guide.
std::uint64_t map_bytes(const PreparedScene& scene, const GatherGuide& guide, const PhotonSettings& photons, Method method);

/// Errors: limit_exceeded where that is more than `limit` bytes, at "/film" or "/photons_per_pass", whichever is more.
Status check_memory(const MemoryNeed& need, std::uint64_t limit);

}  // namespace photond
