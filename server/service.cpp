#include "server/service.h"

#include <filesystem>
#include <optional>
#include <utility>

#include "server/api/api.h"
#include "server/api/contract.h"
#include "server/api/openapi.h"
#include "server/api/task_identity.h"
#include "server/http/routes.h"
#include "server/http/server.h"
#include "server/http/socket.h"
#include "server/jobs/jobs.h"
#include "server/store/answers.h"
#include "server/store/data_directory.h"
#include "server/store/database.h"
#include "server/store/environments.h"
#include "server/store/job_files.h"
#include "server/store/schema.h"
#include "server/store/store.h"

namespace photond {

namespace {

JobLimits job_limits(const ServiceOptions& options) {
  JobLimits limits;
  limits.threads = options.threads;
  limits.map_cache_bytes = options.map_cache_bytes;
  limits.scene_cache_bytes = options.scene_cache_bytes;
  limits.max_pixels = options.max_pixels;
  limits.max_job_memory_bytes = options.max_job_memory_bytes;
  limits.max_live_jobs = options.max_live_jobs;
  limits.max_kept_jobs = options.max_kept_jobs;
  limits.watch_time = options.watch_time;
  limits.drain_time = options.drain_time * 5 / 6;  // the rest for the connections
  limits.disk = {options.disk_quota_bytes, options.disk_reserve_bytes};
  return limits;
}

ApiLimits api_limits(const ServiceOptions& options) {
  ApiLimits limits;
  limits.max_upload_bytes = options.max_upload_bytes;
  limits.max_streams = options.max_streams;
  limits.max_uploads = options.max_uploads;
  limits.max_requests = options.max_requests;
  return limits;
}

std::optional<KeyFile> key_file(const ServiceOptions& options) {
  if (options.data_dir.empty()) return std::nullopt;
  return KeyFile(options.data_dir);
}

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

/// Others than this machine may ask only with keys, or if somebody said that all may.
Status check_exposure(const ServiceOptions& options) {
  if (options.insecure || is_loopback(options.host)) return Done{};
  const auto file = key_file(options);
  const Result<std::vector<KeyRecord>> keys = file ? file->read() : std::vector<KeyRecord>{};
  if (!keys) return keys.error();
  if (!keys->empty()) return Done{};
  return invalid_input("everybody who reaches " + options.host +
                       " could use this service: make a key (photond key create --scope admin --data DIR), or say --insecure");
}

Result<std::string> identity_text(const RenderTask& task) {
  const Result<Json> identity = task_identity(task);
  if (!identity) return identity.error();
  return to_text(*identity);
}

Status check_options(const ServiceOptions& options) {
  if (options.port < 0 || options.port > 65'535) return invalid_input("the port must be from 0 to 65535");
  if (options.threads < 0 || options.threads > 1024) return invalid_input("threads must be from 0 to 1024");
  for (const int count : {options.max_streams, options.max_uploads, options.max_requests}) {
    if (count < 1 || count > kMaxSeats)
      return invalid_input("streams, uploads and requests must be from 1 to " + std::to_string(kMaxSeats));
  }
  if (options.max_live_jobs < 1 || options.max_pixels < 1 || options.max_job_memory_bytes < 1) {
    return invalid_input("jobs, pixels and the memory of a job must be at least 1");
  }
  return Done{};
}

}  // namespace

/// What the data directory holds, opened.
struct Service::Stored {
  DataDirectory directory;
  std::unique_ptr<Database> database;
  std::unique_ptr<Store> store;
  std::unique_ptr<Environments> environments;
  std::unique_ptr<JobFiles> files;
  std::unique_ptr<MapFiles> maps;  ///< null: photon maps stay in memory

  static Result<Stored> open(const ServiceOptions& options) {
    Result<DataDirectory> directory = DataDirectory::open(options.data_dir);
    if (!directory) return directory.error();
    Result<std::unique_ptr<Database>> database = Database::open(directory->database(), schema());
    if (!database) return database.error();
    Result<std::unique_ptr<Store>> store = Store::open(**database, directory->folder("scenes"));
    if (!store) return store.error();
    Result<std::unique_ptr<Environments>> environments =
        Environments::open(**database, directory->folder("environments"));
    if (!environments) return environments.error();
    Result<std::unique_ptr<JobFiles>> files =
        JobFiles::open(**database, directory->folder("frames"), directory->folder("checkpoints"));
    if (!files) return files.error();
    Stored stored{std::move(*directory), std::move(*database), std::move(*store), std::move(*environments),
                  std::move(*files), nullptr};
    if (options.map_disk_bytes == 0) return stored;
    Result<std::unique_ptr<MapFiles>> maps = MapFiles::open(stored.directory.folder("maps"), options.map_disk_bytes);
    if (!maps) return maps.error();
    stored.maps = std::move(*maps);
    return stored;
  }
};

struct Service::State {
  State(const ServiceOptions& o, Contract c, Stored s)
      : options(o),
        contract(std::move(c)),
        keys(key_file(o)),
        stored(std::move(s)),
        jobs(*stored.store, *stored.environments, *stored.files, stored.directory.path(), identity_text, job_limits(o),
             std::move(stored.maps)),
        answers(*stored.database),
        api(*stored.store, jobs, answers, counts, contract, keys, api_limits(o)) {}

  const ServiceOptions options;
  const Contract contract;
  const Keyring keys;
  Stored stored;
  RequestCounts counts;
  Jobs jobs;
  const Answers answers;
  Api api;
  std::unique_ptr<HttpServer> http;
};

Result<std::unique_ptr<Service>> Service::start(const ServiceOptions& options) {
  if (const Status fine = check_options(options); !fine) return fine.error();
  if (const Status fine = check_exposure(options); !fine) return fine.error();
  StaticFiles files;
  if (!options.client_dir.empty()) {
    Result<StaticFiles> loaded = StaticFiles::load(options.client_dir);
    if (!loaded) return loaded.error();
    files = std::move(*loaded);
  }
  std::vector<std::filesystem::path> samples;
  if (!options.samples_dir.empty()) {
    auto found = sample_files(options.samples_dir);
    if (!found) return found.error();
    samples = std::move(*found);
  }
  // Now, and not while somebody waits for the first picture.
  if (const Result<Digest>& program = running_program(); !program) return program.error();
  Result<Contract> contract = Contract::read(kOpenApiText);
  if (!contract) return contract.error();
  Result<Cors> cors = Cors::of(options.cors_origins);
  if (!cors) return cors.error();
  Result<Stored> stored = Stored::open(options);
  if (!stored) return stored.error();
  auto state = std::make_unique<State>(options, std::move(*contract), std::move(*stored));
  if (const Status added = state->jobs.scenes().add_samples(samples); !added) return added.error();
  state->jobs.recover();
  Result<std::vector<Route>> routes = make_routes(state->api);
  if (!routes) return routes.error();
  const HttpOptions http{options.host,
                         options.port,
                         {options.max_streams, options.max_uploads, options.max_requests},
                         options.patience,
                         std::move(*cors),
                         [&keys = state->keys, insecure = options.insecure] { return insecure || keys.required(); }};
  Result<std::unique_ptr<HttpServer>> server =
      HttpServer::start(http, std::move(*routes), std::move(files), state->counts);
  if (!server) return server.error();
  state->http = std::move(*server);
  return std::unique_ptr<Service>(new Service(std::move(state)));
}

Service::Service(std::unique_ptr<State> state) : state_(std::move(state)) {}
Service::~Service() { stop(); }

int Service::port() const { return state_->http->port(); }

std::string Service::url() const { return "http://" + host_and_port(state_->options.host, port()) + "/"; }

void Service::stop() {
  // Jobs first: whoever looks on hears that they go back to the queue before the connections close.
  state_->jobs.stop();
  state_->http->stop();
}

}  // namespace photond
