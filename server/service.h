#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/jobs/machine_memory.h"

namespace photond {

/// The largest of the counts of streams, uploads and requests at once: each may cost a thread.
inline constexpr int kMaxSeats = 10'000;

/// What a service is started with. Sizes are budgets: the service stays near them, pinned data aside.
struct ServiceOptions {
  std::string host = "127.0.0.1";
  int port = 8080;                               ///< 0: any free port, see Service::port
  std::vector<std::string> cors_origins{};       ///< of other sites whose pages may use the service
  bool insecure = false;                         ///< serve a public address though no keys exist
  std::string data_dir;                          ///< all state, keys too; created where missing, used by one service at a time
  std::string samples_dir;                       ///< *.glb listed as sample scenes; empty: none
  std::string client_dir;                        ///< the built web client (index.html inside); empty: none
  int threads = 0;                               ///< render threads; 0: one per core
  std::uint64_t map_cache_bytes = 1ull << 30;    ///< photon maps kept for later jobs
  std::uint64_t map_disk_bytes = 8ull << 30;     ///< photon maps kept on disk, in data_dir
  std::uint64_t scene_cache_bytes = 1ull << 30;  ///< prepared scenes kept for later jobs
  std::uint64_t disk_quota_bytes = 20ull << 30;  ///< of the data directory; 0: what the file system has
  std::uint64_t disk_reserve_bytes = 64ull << 20;  ///< of the file system, left free
  std::uint64_t max_upload_bytes = 256ull << 20;
  std::uint64_t max_pixels = 8'388'608;  ///< of one film
  std::uint64_t max_job_memory_bytes = machine_memory() / 2;  ///< for the film and the photon maps of one job
  int max_live_jobs = 256;               ///< not yet ended; beyond it submissions are refused
  int max_kept_jobs = 1024;              ///< ended; the oldest are forgotten
  int max_streams = 512;                 ///< event streams and long polls at once
  int max_uploads = 8;                   ///< at once; each may take max_upload_bytes of memory
  int max_requests = 64;                 ///< other requests at once
  std::chrono::milliseconds watch_time{30'000};  ///< after somebody has looked at a job its pictures are published
  std::chrono::milliseconds drain_time{18'000};  ///< what `stop` should take at most; who calls it sees to that
  std::chrono::milliseconds patience{10'000};  ///< for a request's head to arrive, and again for a small body
};

/// The running HTTP service. Everything lives inside: several services may run in one process (tests do).
class Service {
 public:
  /// Opens the data directory, takes up the jobs in it, binds the port and serves from threads of its own; returns
  /// once requests are answered. Errors: io (the port is occupied, a directory cannot be read, the database is damaged
  /// or of a newer photond), conflict (another service uses the data directory), invalid_input (an option out of
  /// range).
  static Result<std::unique_ptr<Service>> start(const ServiceOptions& options);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  int port() const;
  /// `http://host:port/`
  std::string url() const;
  /// Refuses new work, writes down the running jobs, which the next start takes up again, ends streams and joins all
  /// threads. Within ServiceOptions::drain_time, unless something that cannot be interrupted takes longer: then the
  /// process may be ended, and the jobs go on from their last checkpoints. May be called more than once, from any thread that serves no request.
  void stop();

 private:
  struct Stored;
  struct State;
  explicit Service(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace photond
