#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/digest.h"
#include "core/base/result.h"
#include "core/film/error.h"
#include "core/photon/settings.h"
#include "core/render/plan.h"
#include "core/render/settings.h"

namespace photond {

using WallTime = std::chrono::system_clock::time_point;
using Blob = std::shared_ptr<const std::vector<std::byte>>;

/// One uploaded or shipped scene file; its id is the SHA-256 of the bytes.
struct SceneRecord {
  Digest id;
  std::string name;        ///< a sample's file stem, or what its uploader calls it; may be empty
  std::string media_type;  ///< model/gltf-binary, model/gltf+json or application/zip
  std::uint64_t bytes = 0;
  bool sample = false;  ///< shipped with the server: cannot be deleted
  WallTime created{};
  std::string owner{};  ///< id of the API key that uploaded it first; empty: none was needed
  std::uint64_t arrival = 0;  ///< ascending; given by the store
};

/// Stored by number: append only.
enum class JobState : std::uint8_t {
  queued,
  preparing,
  rendering,
  finalizing,
  succeeded,
  canceling,
  canceled,
  failed,
  paused
};
inline constexpr int kJobStates = 9;

/// Why a job is paused. Stored by number.
enum class PauseReason : std::uint8_t { none, request, disk_full, disk_unreachable };
/// Whether the job goes on by itself.
inline bool is_by_disk(PauseReason reason) {
  return reason == PauseReason::disk_full || reason == PauseReason::disk_unreachable;
}

enum class Priority : std::uint8_t { interactive, batch };  // stored by number

/// A camera given by its placement instead of by name or index.
struct LookAt {
  Vec3 eye{0};
  Vec3 target{0, 0, -1};
  Vec3 up{0, 1, 0};
  float yfov_deg = 40;
};

/// Index into the scene's cameras, name of one, or a placement.
using CameraChoice = std::variant<std::uint32_t, std::string, LookAt>;

enum class FrameFormat : std::uint8_t { png, jpg, exr };  // stored by number
inline constexpr int kFrameFormats = 3;

/// An environment map to light a scene with.
struct EnvironmentChoice {
  Digest id;
  float rotation_deg = 0;
  float scale = 1;
};

/// What a client asks for.
struct JobSpec {
  Digest scene;
  std::optional<EnvironmentChoice> environment;  ///< nothing: what the scene's file says
  CameraChoice camera = 0u;
  PhotonSettings photons;
  RenderSettings settings;
  StopRule stop;
  Priority priority = Priority::interactive;
  std::string label;
};

/// A published picture in numbers: one point of the curve of error against time.
struct SeriesPoint {
  std::uint32_t revision = 0;
  std::uint32_t passes = 0;
  double seconds = 0;  ///< the job's own compute time
  std::optional<ErrorEstimate> error;
};

/// What changes while a job runs.
struct JobNumbers {
  JobState state = JobState::queued;
  std::uint64_t version = 1;  ///< grows with every stored change
  std::uint32_t passes = 0;
  double seconds = 0;  ///< the job's own compute time
  std::uint64_t rejected = 0;  ///< samples that were not finite or too large
  std::optional<ErrorEstimate> error;
  std::optional<double> eta_seconds;  ///< on the wall clock
  std::uint64_t map_hits = 0;       ///< in memory or on disk
  std::uint64_t map_disk_hits = 0;  ///< of them
  std::uint64_t map_misses = 0;
  std::uint32_t revision = 0;  ///< of the newest picture; 0: none yet
};

/// All that is known of a job, at one version.
struct JobRecord : JobNumbers {
  std::string id;
  std::uint64_t sequence = 0;  ///< ascending with submission
  std::string owner;           ///< id of the API key that submitted it; empty: none was needed
  JobSpec spec;
  WallTime created{};
  std::optional<WallTime> started;
  std::optional<WallTime> finished;
  std::optional<Plan> plan;
  std::optional<double> least_error;          ///< relative, of those by which it might have ended
  std::optional<double> first_frame_seconds;  ///< from leaving the queue to revision 1, wall clock
  std::optional<Error> failure;               ///< of a failed job
  PauseReason pause_reason = PauseReason::none;
  std::uint32_t crashes = 0;                  ///< times the process died in its turn, since its last checkpoint
  std::vector<SeriesPoint> series;
};

/// Stored by number: append only. `gone`: the job was removed.
enum class EventKind : std::uint8_t { state, progress, frame, gone };

/// Something that happened to a job, with the numbers of that moment; of one that is gone its last ones.
struct Event : JobNumbers {
  std::uint64_t id = 0;  ///< ascending over all jobs
  EventKind kind = EventKind::state;
  WallTime time{};
  std::string job;
};

}  // namespace photond
