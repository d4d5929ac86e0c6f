#include "core/render/settings.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <string_view>

namespace photond {

namespace {

Error out_of_range(const char* pointer, const std::string& range) {
  return invalid_input("must be " + range, pointer);
}

}  // namespace

std::uint32_t default_photons(const RenderSettings& render) {
  const std::uint64_t pixels = static_cast<std::uint64_t>(std::max(render.width, 1)) *
                               static_cast<std::uint64_t>(std::max(render.height, 1));
  constexpr std::uint64_t kLeast = 1 << 10, kShared = 1 << 18, kMost = 1 << 22;
  constexpr std::uint64_t kPerPixel = 16;   // in films too small for more to help
  const std::uint64_t least = render.method == Method::photon_map ? kShared : std::clamp(kPerPixel * pixels, kLeast, kShared);
  return static_cast<std::uint32_t>(std::bit_ceil(std::clamp(pixels, least, kMost)));
}

Status check_settings(const PhotonSettings& photons, const RenderSettings& render, const StopRule& stop) {
  if (photons.photons_per_pass < 1 || photons.photons_per_pass > 100'000'000) {
    return out_of_range("/photons_per_pass", "1 to 100000000");
  }
  if (render.width < 1 || render.width > 16'384) return out_of_range("/film/width", "1 to 16384");
  if (render.height < 1 || render.height > 16'384) return out_of_range("/film/height", "1 to 16384");
  if (!(render.radius >= 0) || !std::isfinite(render.radius)) {
    return out_of_range("/radius", "a positive number of metres, or 0 for automatic");
  }
  if (render.gather_photons < 1 || render.gather_photons > 4096) return out_of_range("/gather_photons", "1 to 4096");
  if (render.max_depth < 1 || render.max_depth > 65'536) return out_of_range("/max_depth", "1 to 65536");
  if (stop.passes && *stop.passes < 1) return out_of_range("/stop/passes", "at least 1");
  if (stop.seconds && (!(*stop.seconds > 0) || !std::isfinite(*stop.seconds))) {
    return out_of_range("/stop/seconds", "a positive number");
  }
  if (stop.relative_error && (!(*stop.relative_error > 0) || !std::isfinite(*stop.relative_error))) {
    return out_of_range("/stop/relative_error", "a positive number");
  }
  if (!stop.passes && !stop.seconds && !stop.relative_error) {
    return invalid_input("needs at least one of passes, seconds and relative_error", "/stop");
  }
  return Done{};
}

const char* method_name(Method method) {
  switch (method) {
    case Method::automatic:
      return "auto";
    case Method::path:
      return "path";
    case Method::photon_map:
      return "photon_map";
    case Method::progressive:
      return "progressive";
    case Method::hybrid:
      return "hybrid";
  }
  return "";
}

std::optional<Method> method_from_name(const char* name) {
  for (const Method method : {Method::automatic, Method::path, Method::photon_map, Method::progressive,
                              Method::hybrid}) {
    if (std::string_view(name) == method_name(method)) return method;
  }
  return std::nullopt;
}

}  // namespace photond
