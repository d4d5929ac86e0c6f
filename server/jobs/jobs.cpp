#include "server/jobs/jobs.h"

#include <algorithm>
#include <random>
#include <tuple>
#include <utility>

#include "server/jobs/memory_need.h"
#include "server/jobs/stop_rule.h"
#include "server/jobs/take_turn.h"
#include "server/store/file.h"

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

bool same(const StopRule& a, const StopRule& b) {
  return std::tie(a.passes, a.seconds, a.relative_error) == std::tie(b.passes, b.seconds, b.relative_error);
}

/// Whether a job of this rule would not have come as far. The error of its last pass counts whichever that is, and so
/// does a smaller one on the way, by which it would have ended.
bool has_met(const StopRule& stop, const JobRecord& job) {
  if (rule_met(stop, {job.passes, job.seconds, {}}) != nullptr) return true;
  if (!stop.relative_error) return false;
  const bool in_the_end =
      job.error && job.error->known && is_estimated(job.passes) && job.error->relative <= *stop.relative_error;
  return in_the_end || (job.least_error && *job.least_error <= *stop.relative_error);
}

/// Whether this may become the job's stop rule, or is it.
Status check_later(const StopRule& stop, const JobRecord& job) {
  if (same(job.spec.stop, stop)) return Done{};
  if (job.state != JobState::succeeded) {
    return Error{ErrorCode::conflict, "only a succeeded job can be extended", ""};
  }
  if (!has_met(stop, job)) return Done{};
  // It might begin anew and end with less than there is.
  return invalid_input("/stop must be later: the job has done " + std::to_string(job.passes) + " passes in " +
                           std::to_string(job.seconds) + " s and met this rule",
                       "/stop");
}

/// Of a job that has ended, whose scene need not be there any more.
Error cannot_go_on(const Error& why) {
  if (why.code != ErrorCode::not_found) return why;
  return {ErrorCode::conflict, "the job cannot go on: " + why.message, ""};
}

Error shutting_down() { return {ErrorCode::cancelled, "the service is shutting down", ""}; }

}  // namespace

Jobs::Jobs(Store& store, Environments& environments, JobFiles& files, const std::filesystem::path& data, IdentityOf identity,
           const JobLimits& limits, std::unique_ptr<MapFiles> maps)
    : store_(store),
      files_(files),
      limits_(limits),
      log_(store),
      room_(data, limits.disk, store, environments, files),
      turn_(data / "turn"),
      workers_(limits.threads),
      environments_(environments, room_, limits.scene_cache_bytes / 4),
      scenes_(store, environments_, room_, workers_, limits.scene_cache_bytes),
      maps_(limits.map_cache_bytes, std::move(maps)),
      parts_{scenes_, maps_, workers_, files_, room_, turn_, passes_, limits.max_job_memory_bytes, std::move(identity),
             limits.watch_time},
      scheduler_(limits.max_job_memory_bytes) {
  room_.set_maps({[this] { return maps_.spare_disk(); },
                  [this](std::uint64_t bytes) { return maps_.free_disk(bytes); }});
}

Jobs::~Jobs() { stop(); }

void Jobs::recover() {
  std::vector<JobRecord> records = store_.jobs();
  std::reverse(records.begin(), records.end());  // in the order they came
  const std::lock_guard lock(mutex_);
  for (JobRecord& record : records) {
    const std::string id = record.id;
    const std::shared_ptr<RunJob> run = runs_.emplace(id, make_run(std::move(record))).first->second;
    // Where the disk is full the run itself does this later, or stalls.
    (void)run->put_back().ok();
    const JobState state = run->job()->state();
    if (!is_terminal(state) && state != JobState::paused) put_to_work(run);
  }
  housekeeper_ = std::jthread([this](std::stop_token stop) { keep_house(std::move(stop)); });
}

Result<Plan> Jobs::check(const JobSpec& spec, std::stop_token stop) {
  if (const Status fine = check_settings(spec.photons, spec.settings, spec.stop); !fine) return fine.error();
  const std::uint64_t pixels = static_cast<std::uint64_t>(spec.settings.width) * spec.settings.height;
  if (pixels > limits_.max_pixels) {
    return invalid_input("the film has " + std::to_string(pixels) + " pixels; at most " +
                             std::to_string(limits_.max_pixels) + " are allowed",
                         "/film");
  }
  const MemoryNeed memory = memory_need(spec.settings, spec.photons);
  if (const Status fits = check_memory(memory, limits_.max_job_memory_bytes); !fits) return fits.error();
  const auto summary = scenes_.summary(spec.scene, stop);
  if (!summary) return Error{summary.error().code, summary.error().message, "/scene"};
  if (const Result<Camera> camera = choose_camera((*summary)->cameras, spec.camera); !camera)
    return camera.error();
  if (spec.settings.method == Method::automatic && spec.settings.radius == 0 && !spec.environment)
    return (*summary)->plan;
  const Execution execution = workers_.execution(stop);
  const auto scene = scenes_.prepared(spec.scene, spec.environment, execution);
  if (!scene) return scene.error();
  return make_plan(**scene, spec.settings, execution);
}

Result<JobEstimate> Jobs::estimate(const JobSpec& spec, std::stop_token stop) {
  if (const Result<Plan> plan = check(spec, stop); !plan) return plan.error();
  if (!estimates_.try_acquire()) {
    return Error{ErrorCode::limit_exceeded, "too many dry runs at once; try again later", "queue"};
  }
  const std::shared_ptr<void> place(&estimates_, [](std::counting_semaphore<2>* places) { places->release(); });
  const auto turn = take_turn(estimating_, stop);
  if (!turn) return cancelled();
  const Execution execution = workers_.execution(stop);
  const auto scene = scenes_.prepared(spec.scene, spec.environment, execution);
  if (!scene) return scene.error();
  const Result<Camera> camera = choose_camera((*scene)->scene.cameras, spec.camera);
  if (!camera) return camera.error();
  return estimate_job(*scene, *camera, spec, {limits_.max_job_memory_bytes, limits_.map_cache_bytes / 4}, execution);
}

Result<JobRecord> Jobs::submit(const JobSpec& spec, const Owner& owner, std::stop_token stop, const Also& also) {
  if (stopping_) return shutting_down();
  if (const Result<Plan> plan = check(spec, stop); !plan) return plan.error();
  const std::lock_guard lock(mutex_);
  const auto held = room_.hold();
  if (const Status there = check_needs(spec); !there) return there.error();
  if (const Status room = check_room(owner); !room) return room.error();
  if (const Status forgotten = forget_oldest(); !forgotten) return forgotten.error();
  JobRecord record;
  record.id = new_id();
  record.owner = owner.key;
  record.spec = spec;
  record.created = std::chrono::system_clock::now();
  Event created;
  created.job = record.id;
  created.time = record.created;
  created.version = record.version;
  const Database::Body with_it = [&](Transaction& transaction) -> Status {
    return also ? also(transaction, record) : Status(Done{});
  };
  if (const Status added = log_.add(record, created, with_it); !added) return added.error();
  put_to_work(runs_.emplace(record.id, make_run(record)).first->second);
  return record;
}

Result<JobRecord> Jobs::cancel(const std::string& id, const Guard& guard) {
  const std::shared_ptr<RunJob> run = find(id);
  if (!run) return no_job(id);
  Job& job = *run->job();
  const Status moved = job.move(JobState::canceling, {}, guard);
  const JobState after = job.state();
  const bool done = after == JobState::canceling || after == JobState::canceled;
  if (!moved && (moved.error().code != ErrorCode::conflict || !done)) return moved.error();
  run->cancel();
  put_to_work(run);
  // A job whose turn it is not need not wait for it. A refusal says that its turn has come meanwhile.
  if (scheduler_.hurry(run)) (void)job.move(JobState::canceled).ok();
  return job.record();
}

Result<JobRecord> Jobs::pause(const std::string& id, const Guard& guard) {
  const std::shared_ptr<RunJob> run = find(id);
  if (!run) return no_job(id);
  if (const Status paused = run->job()->pause(guard); !paused) return paused.error();
  run->interrupt();
  scheduler_.hurry(run);
  return run->job()->record();
}

Result<JobRecord> Jobs::resume(const std::string& id, const Guard& guard) {
  return start_again(id, JobState::paused, {}, {}, guard);
}

Result<JobRecord> Jobs::extend(const std::string& id, const StopRule& stop, const Owner& by, const Guard& guard) {
  const std::shared_ptr<RunJob> run = find(id);
  if (!run) return no_job(id);
  const JobRecord now = run->job()->record();
  if (const Status fine = check_settings(now.spec.photons, now.spec.settings, stop); !fine) return fine.error();
  const Guard fits = [&](const JobRecord& job) -> Status {
    const Status fine = guard ? guard(job) : Status(Done{});
    return fine ? check_later(stop, job) : fine;
  };
  if (now.state == JobState::succeeded && same(now.spec.stop, stop) && has_met(stop, now)) {  // there already
    if (const Status fine = fits(now); !fine) return fine.error();
    return now;
  }
  return start_again(id, JobState::succeeded, by, [&](JobRecord& record) { record.spec.stop = stop; }, fits);
}

Result<JobRecord> Jobs::retry(const std::string& id, const Owner& by, const Guard& guard) {
  const auto afresh = [](JobRecord& record) {
    record.failure.reset();
    record.crashes = 0;
  };
  return start_again(id, JobState::failed, by, afresh, guard);
}

/// Moves a job that rests in `from` back to the queue. One that is on its way is left as it is.
Result<JobRecord> Jobs::start_again(const std::string& id, JobState from, const Owner& by, const Job::Edit& edit,
                                    const Guard& guard) {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(id);
  if (found == runs_.end()) return no_job(id);
  const std::shared_ptr<RunJob>& run = found->second;
  const JobRecord now = run->job()->record();
  if (const Status fine = guard ? guard(now) : Status(Done{}); !fine) return fine.error();
  if (now.state == JobState::queued || is_running(now.state)) return now;
  if (now.state != from) {
    return Error{ErrorCode::conflict,
                 std::string("the job is ") + state_name(now.state) + ", not " + state_name(from), ""};
  }
  const bool own = run->job()->owner == by.key;  // else it does not count as theirs
  if (const Status room = check_room(own ? by : Owner{}); !room && from != JobState::paused) return room.error();
  const auto held = room_.hold();
  const Status there = check_needs(now.spec);
  if (!there && from != JobState::paused) return cannot_go_on(there.error());
  if (const Status moved = run->job()->move(JobState::queued, edit, guard); !moved) return moved.error();
  put_to_work(run);
  return run->job()->record();
}

Status Jobs::remove(const std::string& id, const Guard& guard) {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(id);
  if (found == runs_.end()) return no_job(id);
  const JobRecord now = found->second->job()->record();
  if (const Status fine = guard ? guard(now) : Status(Done{}); !fine) return fine;
  if (!is_terminal(now.state)) {  // one that has ended goes on only under this lock
    return Error{ErrorCode::conflict, "the job has not ended; cancel it first", ""};
  }
  return forget(id);
}

Status Jobs::remove_scene(const Digest& id) {
  const auto scene = store_.scene(id);
  if (!scene) return Error{ErrorCode::not_found, "there is no scene " + to_hex(id), ""};
  if (scene->sample) return Error{ErrorCode::conflict, "a sample scene cannot be deleted", ""};
  const std::lock_guard lock(mutex_);
  for (const auto& [name, run] : runs_) {
    if (run->job()->spec.scene == id && !is_terminal(run->job()->state())) {
      return Error{ErrorCode::conflict, "job " + name + " needs this scene", ""};
    }
  }
  return store_.remove_scene(id);
}

Result<Jobs::Prewarmed> Jobs::prewarm(const PrewarmSpec& spec, const std::string& owner, std::stop_token stop) {
  StopRule passes;
  passes.passes = spec.passes;
  if (const Status fine = check_settings(spec.photons, {}, passes); !fine) return fine.error();
  const MemoryNeed memory{0, memory_need({.method = spec.method}, spec.photons).maps};
  if (const Status fits = check_memory(memory, limits_.max_job_memory_bytes); !fits) return fits.error();
  const auto scene = scenes_.prepared(spec.scene, workers_.execution(stop));
  if (!scene) return Error{scene.error().code, scene.error().message, "/scene"};
  Prewarmed result{(*scene)->digest, prewarm_keys(spec, (*scene)->digest)};
  for (const MapKey& key : result.keys) result.ready += maps_.find(key) ? 1 : 0;
  if (result.ready == result.keys.size()) return result;
  const std::lock_guard lock(mutex_);
  if (stopping_) return shutting_down();
  std::erase_if(prewarms_, [](const auto& prewarm) { return prewarm.second->ended(); });
  if (prewarms_.contains(spec)) return result;
  if (prewarms_.size() >= kMaxPrewarms) {
    return Error{ErrorCode::limit_exceeded, "too many photon maps are waiting to be built; try again later", "queue"};
  }
  const auto work = std::make_shared<Prewarm>(spec, result.keys, owner, scenes_, maps_, workers_,
                                              limits_.max_job_memory_bytes);
  prewarms_.emplace(spec, work);
  scheduler_.submit(work, Priority::batch);
  return result;
}

bool Jobs::cancel_prewarms(const MapKey& key, const std::optional<std::string>& owner) {
  const std::lock_guard lock(mutex_);
  if (maps_.find(key)) return false;
  return std::erase_if(prewarms_, [&](const auto& entry) {
           const std::shared_ptr<Prewarm>& prewarm = entry.second;
           if (prewarm->ended() || !prewarm->names(key) || (owner && prewarm->owner() != *owner)) return false;
           prewarm->cancel();
           scheduler_.hurry(prewarm);  // so that it waits for nobody's turn to let go of its scene
           return true;
         }) > 0;
}

std::shared_ptr<const Job> Jobs::job(const std::string& id) const {
  const std::shared_ptr<RunJob> run = find(id);
  return run ? run->job() : nullptr;
}

Status Jobs::remove_environment(const Digest& id) {
  if (const auto known = environments_.find(id); !known) return known.error();
  const std::lock_guard lock(mutex_);
  for (const auto& [name, run] : runs_) {
    const auto& choice = run->job()->spec.environment;
    if (choice && choice->id == id && !is_terminal(run->job()->state())) {
      return Error{ErrorCode::conflict, "job " + name + " needs this environment", ""};
    }
  }
  return environments_.remove(id);
}

std::shared_ptr<RunJob> Jobs::find(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = runs_.find(id);
  return found == runs_.end() ? nullptr : found->second;
}

std::shared_ptr<RunJob> Jobs::make_run(JobRecord record) {
  return std::make_shared<RunJob>(std::make_shared<Job>(std::move(record), log_), parts_);
}

void Jobs::put_to_work(const std::shared_ptr<RunJob>& run) {
  if (run->claim()) scheduler_.submit(run, run->job()->spec.priority);
}

/// Whether one more job, of this owner, may be on its way.
Status Jobs::check_room(const Owner& owner) const {
  if (stopping_) return shutting_down();
  if (const Status found = room_.found(); !found) return found;
  if (room_.full()) return disk_full("the disk is full; try again when there is room");
  int live = 0;
  std::uint64_t own = 0;
  for (const auto& [id, run] : runs_) {
    if (is_terminal(run->job()->state())) continue;
    ++live;
    own += run->job()->owner == owner.key ? 1 : 0;
  }
  if (live >= limits_.max_live_jobs)
    return Error{ErrorCode::limit_exceeded, "too many jobs are waiting; try again later", "queue"};
  if (owner.limits.jobs && own >= *owner.limits.jobs)
    return Error{ErrorCode::limit_exceeded, "too many jobs of this key have not ended; try again later", "queue"};
  return Done{};
}

/// Whether what a job is made of is there. While `mutex_` and the room are held it stays.
Status Jobs::check_needs(const JobSpec& spec) const {
  if (!store_.scene(spec.scene)) {
    return Error{ErrorCode::not_found, "there is no scene " + to_hex(spec.scene), "/scene"};
  }
  if (!spec.environment) return Done{};
  const auto found = environments_.find(spec.environment->id);
  return found ? Status(Done{}) : Error{found.error().code, found.error().message, "/environment/id"};
}

void Jobs::stop() {
  housekeeper_.request_stop();
  if (housekeeper_.joinable()) housekeeper_.join();
  {
    const std::lock_guard lock(mutex_);
    if (stopping_.exchange(true)) return;
    for (const auto& [spec, prewarm] : prewarms_) prewarm->cancel();
    for (const auto& [id, run] : runs_) {
      run->drain();
      if (run->unsaved() || run->stalled()) put_to_work(run);  // once more
    }
  }
  scheduler_.wait_idle(limits_.drain_time);
  scheduler_.stop();
}

}  // namespace photond
