#include "server/jobs/jobs.h"

#include <algorithm>
#include <random>
#include <utility>

namespace photond {

namespace {

std::string new_id() {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::random_device random;
  std::string id = "j-";
  for (int word = 0; word < 2; ++word) {
    std::uint32_t bits = random();
    for (int digit = 0; digit < 8; ++digit, bits >>= 4) id += kDigits[bits & 15];
  }
  return id;
}

constexpr std::size_t kMaxPrewarms = 64;  // waiting or running

Error no_job(const std::string& id) { return {ErrorCode::not_found, "there is no job " + id, ""}; }

}  // namespace

Jobs::Jobs(Store& store, const JobLimits& limits, std::unique_ptr<MapFiles> files)
    : store_(store),
      limits_(limits),
      log_(store),
      workers_(limits.threads),
      scenes_(store, workers_, limits.scene_cache_bytes),
      maps_(limits.map_cache_bytes, std::move(files)) {}

Jobs::~Jobs() { stop(); }

Result<Plan> Jobs::check(const JobSpec& spec, std::stop_token stop) {
  if (const Status fine = check_settings(spec.photons, spec.settings, spec.stop); !fine) return fine.error();
  const std::uint64_t pixels = static_cast<std::uint64_t>(spec.settings.width) * spec.settings.height;
  if (pixels > limits_.max_pixels) {
    return invalid_input("the film has " + std::to_string(pixels) + " pixels; at most " +
                             std::to_string(limits_.max_pixels) + " are allowed",
                         "/film");
  }
  const auto summary = scenes_.summary(spec.scene, stop);
  if (!summary) return Error{summary.error().code, summary.error().message, "/scene"};
  if (const Result<Camera> camera = choose_camera((*summary)->cameras, spec.camera); !camera)
    return camera.error();
  if (spec.settings.method == Method::automatic) return (*summary)->plan;
  const Execution execution = workers_.execution(stop);
  const auto scene = scenes_.prepared(spec.scene, execution);
  if (!scene) return Error{scene.error().code, scene.error().message, "/scene"};
  return make_plan(**scene, spec.settings, execution);
}

Result<JobRecord> Jobs::submit(const JobSpec& spec, std::stop_token stop) {
  if (const Result<Plan> plan = check(spec, stop); !plan) return plan.error();
  const std::lock_guard lock(mutex_);
  if (stopping_) return Error{ErrorCode::conflict, "the service is shutting down", ""};
  const auto live = std::count_if(runs_.begin(), runs_.end(),
                                  [](const auto& run) { return !is_terminal(run.second->job()->state()); });
  if (live >= limits_.max_live_jobs) {
    return Error{ErrorCode::limit_exceeded, "too many jobs are waiting; try again later", "queue"};
  }
  forget_oldest();
  JobRecord record;
  record.id = new_id();
  record.spec = spec;
  record.created = std::chrono::system_clock::now();
  Event created;
  created.job = record.id;
  created.time = record.created;
  created.version = record.version;
  if (const Status added = log_.add(record, created); !added) return added.error();
  const auto run =
      std::make_shared<RunJob>(std::make_shared<Job>(record, log_), scenes_, maps_, workers_, passes_);
  runs_.emplace(record.id, run);
  scheduler_.submit(run, spec.priority);
  return record;
}

Result<JobRecord> Jobs::cancel(const std::string& id) {
  const std::shared_ptr<RunJob> run = find(id);
  if (!run) return no_job(id);
  if (const Status asked = run->job()->cancel(); !asked) return asked.error();
  // A job whose turn it is not would wait for its next slice, behind the passes of others.
  if (scheduler_.withdraw(run)) run->abandon();
  return run->job()->record();
}

Status Jobs::remove(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(id);
  if (found == runs_.end()) return no_job(id);
  if (!is_terminal(found->second->job()->state())) {
    return Error{ErrorCode::conflict, "the job has not ended; cancel it first", ""};
  }
  runs_.erase(found);
  store_.remove_job(id);
  return Done{};
}

Status Jobs::remove_scene(const Digest& id) {
  const auto scene = store_.scene(id);
  if (!scene) return Error{ErrorCode::not_found, "there is no scene " + to_hex(id), ""};
  if (scene->sample) return Error{ErrorCode::conflict, "a sample scene cannot be deleted", ""};
  const std::lock_guard lock(mutex_);
  for (const auto& [name, run] : runs_) {
    if (run->job()->spec().scene == id && !is_terminal(run->job()->state())) {
      return Error{ErrorCode::conflict, "job " + name + " needs this scene", ""};
    }
  }
  store_.remove_scene(id);
  return Done{};
}

Result<Jobs::Prewarmed> Jobs::prewarm(const PrewarmSpec& spec, std::stop_token stop) {
  StopRule passes;
  passes.passes = spec.passes;
  if (const Status fine = check_settings(spec.photons, {}, passes); !fine) return fine.error();
  const auto scene = scenes_.prepared(spec.scene, workers_.execution(stop));
  if (!scene) return Error{scene.error().code, scene.error().message, "/scene"};
  Prewarmed result{(*scene)->digest, prewarm_keys(spec, (*scene)->digest)};
  for (const MapKey& key : result.keys) result.ready += maps_.find(key) ? 1 : 0;
  if (result.ready == result.keys.size()) return result;
  const std::lock_guard lock(mutex_);
  if (stopping_) return Error{ErrorCode::conflict, "the service is shutting down", ""};
  std::erase_if(prewarms_, [](const auto& prewarm) { return prewarm.second->ended(); });
  if (prewarms_.contains(spec)) return result;
  if (prewarms_.size() >= kMaxPrewarms) {
    return Error{ErrorCode::limit_exceeded, "too many photon maps are waiting to be built; try again later", "queue"};
  }
  const auto work = std::make_shared<Prewarm>(spec, scenes_, maps_, workers_, stop_prewarming_.get_token());
  prewarms_.emplace(spec, work);
  scheduler_.submit(work, Priority::batch);
  return result;
}

Result<Frames::Bytes> Jobs::frame(const std::string& id, std::uint32_t revision, FrameFormat format) const {
  const std::shared_ptr<RunJob> run = find(id);
  if (!run) return no_job(id);
  return run->job()->frames.get(revision, format);
}

std::shared_ptr<RunJob> Jobs::find(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(id);
  return found == runs_.end() ? nullptr : found->second;
}

void Jobs::forget_oldest() {
  std::vector<std::pair<std::uint64_t, std::string>> ended;
  std::uint64_t bytes = 0;
  for (const auto& [id, run] : runs_) {
    const JobRecord record = run->job()->record();
    if (!is_terminal(record.state)) continue;
    ended.emplace_back(record.sequence, id);
    bytes += run->job()->frames.memory_bytes();
  }
  std::sort(ended.begin(), ended.end());
  std::size_t kept = ended.size();
  for (const auto& [sequence, id] : ended) {
    if (bytes <= limits_.picture_bytes && kept <= static_cast<std::size_t>(limits_.max_kept_jobs)) return;
    bytes -= runs_.at(id)->job()->frames.memory_bytes();
    --kept;
    runs_.erase(id);
    store_.remove_job(id);
  }
}

void Jobs::stop() {
  std::vector<std::string> live;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    stop_prewarming_.request_stop();
    for (const auto& [id, run] : runs_) {
      if (!is_terminal(run->job()->state())) live.push_back(id);
    }
  }
  for (const std::string& id : live) (void)cancel(id).ok();  // one that has just ended needs no cancelling
  scheduler_.stop();
}

}  // namespace photond
