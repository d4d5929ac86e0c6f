#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "server/api/authorize.h"
#include "server/api/message.h"
#include "server/api/request_counts.h"
#include "server/api/underway.h"
#include "server/jobs/jobs.h"
#include "server/store/answers.h"
#include "server/store/store.h"

namespace photond {

class Contract;
struct FrameWish;

/// Limits that belong to the interface rather than to the work; shown by /v1/info.
struct ApiLimits {
  std::uint64_t max_upload_bytes = 256ull << 20;
  std::uint64_t max_message_bytes = 64 * 1024;  ///< of a job
  int max_streams = 512;
  int max_uploads = 8;
  int max_requests = 64;
};

/// What answers each route: bytes to native types, a call into the jobs, native types to bytes. The routes
/// themselves are in server/http/routes.cpp. Requests have been checked by the contract (check_request.h).
class Api {
 public:
  /// All references must outlive the object.
  Api(Store& store, Jobs& jobs, const Answers& answers, const RequestCounts& counts, const Contract& contract,
      const Keyring& keys, const ApiLimits& limits)
      : store_(store),
        jobs_(jobs),
        answers_(answers),
        counts_(counts),
        contract_(contract),
        keys_(keys),
        limits_(limits) {}

  const Contract& contract() const { return contract_; }
  const Keyring& keys() const { return keys_; }
  OpenStreams& streams() { return streams_; }
  const ApiLimits& limits() const { return limits_; }

  // system_handlers.cpp
  Response health(const Request& request) const;
  Response ready(const Request& request) const;
  Response metrics(const Request& request) const;
  Response info(const Request& request) const;
  Response openapi(const Request& request) const;

  // map_handlers.cpp
  Response list_maps(const Request& request) const;
  Response post_map(const Request& request);
  Response delete_map(const Request& request);
  Response pin_map(const Request& request);
  Response unpin_map(const Request& request);

  // scene_handlers.cpp
  Response post_scene(Request& request);
  Response list_scenes(const Request& request) const;
  Response get_scene(const Request& request);
  Response get_scene_file(const Request& request) const;
  Response delete_scene(const Request& request);

  // environment_handlers.cpp
  Response post_environment(Request& request);
  Response list_environments(const Request& request) const;
  Response get_environment(const Request& request) const;
  Response delete_environment(const Request& request);

  // job_handlers.cpp
  Response post_job(const Request& request);
  Response list_jobs(const Request& request) const;
  Response get_job(const Request& request) const;
  Response cancel_job(const Request& request);
  Response pause_job(const Request& request);
  Response resume_job(const Request& request);
  Response extend_job(const Request& request);
  Response retry_job(const Request& request);
  Response delete_job(const Request& request);
  Response get_series(const Request& request) const;

  // frame_handlers.cpp
  Response get_frame(const Request& request) const;

  // checkpoint_handler.cpp
  Response get_checkpoint(const Request& request) const;

  // picture_stream.cpp
  Response picture_stream(const Request& request) const;

  // event_stream.cpp
  Response job_events(const Request& request) const;
  Response all_events(const Request& request) const;

 private:
  /// Submits a job, unless a request of this idempotency key was answered before or is being answered.
  Response submit_once(const Request& request, const JobSpec& spec, const std::string& key);
  using JobChange = std::function<Result<JobRecord>(const std::string& id, const Jobs::Guard& guard)>;
  /// Makes a change that the caller may make, of the version that If-Match names.
  Response change_job(const Request& request, const JobChange& change);
  /// 403 where the job is another's.
  std::optional<Response> foreign_job(const Request& request) const;
  Response latest_frame(const Request& request, const FrameWish& wish) const;
  Response set_pinned(const Request& request, bool pinned);
  Response frame_response(const std::string& id, std::uint32_t revision, const FrameWish& wish) const;

  Store& store_;
  Jobs& jobs_;
  const Answers& answers_;
  const RequestCounts& counts_;
  const Contract& contract_;
  const Keyring& keys_;
  const ApiLimits limits_;
  OpenStreams streams_;
  Underway underway_;
};

}  // namespace photond
