#include "server/jobs/memory_need.h"

#include <string>

#include "core/film/film.h"

namespace photond {

namespace {

std::uint64_t pixels(const RenderSettings& settings) {
  return static_cast<std::uint64_t>(settings.width) * static_cast<std::uint64_t>(settings.height);
}

std::uint64_t kept_bytes(const RenderSettings& settings, bool banded) {
  constexpr std::uint64_t kSums = sizeof(Film::Sums::value_type), kSquares = sizeof(Film::SquareSums::value_type);
  // The sums of complete blocks and of an open one, the squares of blocks and of passes, the largest pass.
  constexpr std::uint64_t kPixel = 2 * kSums + 2 * kSquares + sizeof(float);
  constexpr std::uint64_t kBanded = sizeof(Film::BandSums) + sizeof(Bands);
  return pixels(settings) * (kPixel + (banded ? kBanded : 0));
}

std::uint64_t film_bytes(const RenderSettings& settings, bool banded) {
  return kept_bytes(settings, banded) + pixels(settings) * kPictureBytes;
}

}  // namespace

std::uint64_t film_memory(const RenderSettings& settings) {
  const bool may_be_banded = settings.method != Method::path && settings.method != Method::photon_map;
  return kept_bytes(settings, may_be_banded);
}

MemoryNeed memory_need(const RenderSettings& settings, const PhotonSettings& photons) {
  const bool stores = settings.method == Method::progressive || settings.method == Method::photon_map;
  return {film_bytes(settings, settings.method == Method::progressive),
          stores ? photons.photons_per_pass * sizeof(Photon) : 0};
}

MemoryNeed memory_need(const RenderTask& task, const RenderSettings& settings) {
  const Method method = task.plan.method;
  MemoryNeed need{film_bytes(settings, task.plan.uses_maps && method != Method::photon_map), 0};
  if (task.guide) need.maps = map_bytes(*task.scene, *task.guide, task.photons, method);
  return need;
}

// The index takes the place of the photons that are gathered for it, and takes less.
std::uint64_t map_bytes(const PreparedScene& scene, const GatherGuide& guide, const PhotonSettings& photons,
                        Method method) {
  double stored = guide.pilot->caustic.size();
  if (method != Method::hybrid) {
    stored += guide.pilot->global.size();
  } else if (const double share = scene.lights.casting_share(); share > 0) {
    stored /= share;  // its paths all begin at lights whose caustics count
  }
  return static_cast<std::uint64_t>(stored * sizeof(Photon) / static_cast<double>(pilot_share(photons)));
}

Status check_memory(const MemoryNeed& need, std::uint64_t limit) {
  if (need.film + need.maps <= limit) return Done{};
  const auto megabytes = [](std::uint64_t bytes) { return std::to_string(bytes >> 20) + " MB"; };
  return Error{ErrorCode::limit_exceeded,
               "the film takes " + megabytes(need.film) + " and its photons at least " + megabytes(need.maps) +
                   "; together they may take " + megabytes(limit) + " (max_job_memory_bytes of /v1/info)",
               need.film >= need.maps ? "/film" : "/photons_per_pass"};
}

}  // namespace photond
