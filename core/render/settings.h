#pragma once

#include <cstdint>
#include <optional>

#include "core/base/result.h"
#include "core/photon/settings.h"

namespace photond {

/// The light-transport method of a picture.
enum class Method : std::uint8_t {
  automatic,    ///< chosen by make_plan
  path,         ///< path tracing with next-event estimation and MIS: unbiased
  photon_map,   ///< two passes: direct by shadow rays, caustics from the map, indirect by final gather: biased
  progressive,  ///< independent passes with shrinking radius, all indirect light by photons: consistent
  hybrid,       ///< paths, and photons for light that comes by way of mirrors and glass: consistent
};

/// Exactly what changes a picture but no photon map (the camera is passed beside it).
struct RenderSettings {
  Method method = Method::automatic;
  int width = 512;                           ///< 1 … 16384
  int height = 512;
  std::uint64_t seed = 0;
  float radius = 0;                          ///< widest gather radius of the first pass in metres; 0: chosen for each gather
  std::uint32_t gather_photons = 64;         ///< k of the k-nearest estimates where the eye looks (photon_map), 1 … 4096
  std::uint32_t max_depth = 65'536;          ///< bounces of a path; those cut are counted: Image::truncated
};

/// When a job is done: at whichever comes first. At least one must be set.
struct StopRule {
  std::optional<std::uint32_t> passes;
  std::optional<double> seconds;
  std::optional<double> relative_error;      ///< of ErrorEstimate::relative
};

/// The photons per pass of a picture where nobody asks for a number: about one for each pixel, a power of two from 262,144,
/// so that pictures of 128×128 to 512×512 pixels share their maps, to 4,194,304. With fewer, a pass spends its time on pixels
/// that gather the same few photons. Smaller pictures, but those of photon_map, take 16 for each pixel and at least 1024: with
/// more, a pass spends its time on photons, and too few samples show what is within a pixel.
std::uint32_t default_photons(const RenderSettings& render);

/// Errors name the field as a JSON pointer of the job message: `/photons_per_pass`, `/film/width`, `/radius`.
Status check_settings(const PhotonSettings& photons, const RenderSettings& render, const StopRule& stop);

const char* method_name(Method method);      ///< "auto", "path", "photon_map", "progressive", "hybrid"
std::optional<Method> method_from_name(const char* name);

}  // namespace photond
