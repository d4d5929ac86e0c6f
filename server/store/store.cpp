#include "server/store/store.h"

#include <algorithm>

#include "server/store/record_text.h"
#include "server/store/uploads.h"

namespace photond {

namespace {

constexpr std::size_t kStateEvents = 256;  // per job: pausing and resuming may go on for ever
constexpr std::size_t kGoneEvents = 1024;  // of all jobs: whoever was away for longer asks for the jobs that there are
constexpr std::uint64_t kReserved = 1000;  // event ids at a time

Error no_job(const std::string& id) { return {ErrorCode::not_found, "there is no job " + id, ""}; }

/// The place of the event that one of `kind` supersedes: progress and frames tell only of the newest moment.
std::optional<std::size_t> superseded(const std::deque<Event>& events, EventKind kind) {
  const auto same = [kind](const Event& event) { return event.kind == kind; };
  if (kind == EventKind::state) {
    const auto states = std::count_if(events.begin(), events.end(), same);
    if (static_cast<std::size_t>(states) < kStateEvents) return std::nullopt;
  }
  const auto found = std::find_if(events.begin(), events.end(), same);
  if (found == events.end()) return std::nullopt;
  return static_cast<std::size_t>(found - events.begin());
}

Status insert_series(Transaction& transaction, const JobRecord& job, std::size_t known) {
  for (std::size_t i = known; i < job.series.size(); ++i) {
    const SeriesPoint& point = job.series[i];
    const Status added = transaction.run("INSERT INTO series VALUES (?, ?, ?, ?, ?)", job.id, point.revision,
                                         point.passes, point.seconds, error_text(point.error));
    if (!added) return added;
  }
  return Done{};
}

Result<std::vector<SeriesPoint>> load_series(Transaction& transaction, const std::string& job) {
  Query query = transaction.query(
      "SELECT revision, passes, seconds, error FROM series WHERE job = ? ORDER BY revision", job);
  std::vector<SeriesPoint> series;
  while (query.next()) {
    const auto error = read_error(query.text(3));
    if (!error) return error.error();
    series.push_back({static_cast<std::uint32_t>(query.whole(0)), static_cast<std::uint32_t>(query.whole(1)),
                      query.real(2), *error});
  }
  if (const Status read = query.status(); !read) return read.error();
  return series;
}

Result<std::uint64_t> load_counter(Transaction& transaction, const char* name) {
  Query query = transaction.query("SELECT value FROM counters WHERE name = ?", name);
  const std::uint64_t value = query.next() ? query.whole(0) : 0;
  if (const Status read = query.status(); !read) return read.error();
  return value;
}

}  // namespace

// --- loading ------------------------------------------------------------------------------------------------------

Result<std::unique_ptr<Store>> Store::open(Database& database, const std::filesystem::path& scene_files) {
  Result<std::unique_ptr<Blobs>> files = Blobs::open(scene_files);
  if (!files) return files.error();
  std::unique_ptr<Store> store(new Store(database, std::move(*files)));
  if (const Status loaded = store->load(); !loaded) return loaded.error();
  if (const Status forgotten = store->forget_samples(); !forgotten) return forgotten.error();
  const auto swept = store->files_->sweep([&](const Digest& id) { return store->scenes_.contains(id); });
  if (!swept) return swept.error();
  return store;
}

Status Store::load() {
  return database_.read([this](Transaction& transaction) -> Status {
    if (const Status scenes = load_scenes(transaction); !scenes) return scenes;
    if (const Status jobs = load_jobs(transaction); !jobs) return jobs;
    if (const Status gone = load_gone(transaction); !gone) return gone;
    const auto sequence = load_counter(transaction, "job_sequence");
    if (!sequence) return sequence.error();
    const auto reserved = load_counter(transaction, "events_reserved");
    if (!reserved) return reserved.error();
    last_sequence_ = *sequence;
    last_event_ = reserved_events_ = *reserved;  // those in between may have been given and lost with the power
    return Done{};
  });
}

Status Store::load_scenes(Transaction& transaction) {
  Query query =
      transaction.query("SELECT id, arrival, name, media_type, bytes, sample, created_ms, owner FROM scenes");
  while (query.next()) {
    SceneRecord scene;
    const std::vector<std::byte> id = query.bytes(0);
    if (id.size() != sizeof scene.id.bytes) return Error{ErrorCode::io, "a scene has no id", ""};
    std::copy(id.begin(), id.end(), reinterpret_cast<std::byte*>(scene.id.bytes.data()));
    scene.arrival = query.whole(1);
    scene.name = query.text(2);
    scene.media_type = query.text(3);
    scene.bytes = query.whole(4);
    scene.sample = query.integer(5) != 0;
    scene.created = WallTime(std::chrono::milliseconds(query.integer(6)));
    scene.owner = query.text(7);
    next_arrival_ = std::max(next_arrival_, scene.arrival + 1);
    scenes_.emplace(scene.id, scene);
  }
  return query.status();
}

Status Store::load_jobs(Transaction& transaction) {
  Query jobs = transaction.query("SELECT record FROM jobs");
  while (jobs.next()) {
    Result<JobRecord> job = read_record(jobs.text(0));
    if (!job) return job.error();
    Result<std::vector<SeriesPoint>> series = load_series(transaction, job->id);
    if (!series) return series.error();
    job->series = std::move(*series);
    jobs_[job->id].record = std::move(*job);
  }
  if (const Status read = jobs.status(); !read) return read;
  Query events = transaction.query("SELECT event FROM events ORDER BY id");
  while (events.next()) {
    Result<Event> event = read_event(events.text(0));
    if (!event) return event.error();
    jobs_[event->job].events.push_back(std::move(*event));
  }
  return events.status();
}

Status Store::load_gone(Transaction& transaction) {
  Query query = transaction.query("SELECT event FROM gone ORDER BY id");
  while (query.next()) {
    Result<Event> event = read_event(query.text(0));
    if (!event) return event.error();
    gone_.push_back(std::move(*event));
  }
  return query.status();
}

/// What is a sample is said anew at each start: a folder of samples may have changed.
Status Store::forget_samples() {
  const Status written =
      database_.write([](Transaction& t) { return t.run("UPDATE scenes SET sample = 0 WHERE sample"); });
  if (!written) return written;
  for (auto& [id, scene] : scenes_) scene.sample = false;
  return Done{};
}

// --- scenes -------------------------------------------------------------------------------------------------------

Status Store::put_scene(const SceneRecord& scene, const std::vector<std::byte>& bytes,
                        const std::optional<std::uint64_t>& owner_bytes) {
  const bool there = this->scene(scene.id).has_value();
  if (there && !scene.sample) return Done{};
  // A large file takes its time: it is written before anybody has to wait. A sample's costs nothing to mend.
  std::optional<Blobs::Written> file;
  if (!there || !files_->get(scene.id)) {
    Result<Blobs::Written> written = files_->write([&bytes](const Blobs::Sink& sink) { return sink(bytes); });
    if (!written) return written.error();
    file.emplace(std::move(*written));
  }
  const std::lock_guard lock(writing_);
  const auto known = scenes_.find(scene.id);
  if (known != scenes_.end() && !scene.sample) return Done{};   // added meanwhile
  if (file) {
    if (const Status published = files_->publish(*file); !published) return published;
  }
  SceneRecord stored = scene;
  stored.arrival = known == scenes_.end() ? next_arrival_ : known->second.arrival;
  const auto created_ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(scene.created.time_since_epoch()).count();
  const Status written = database_.write([&](Transaction& transaction) {
    if (const Status fits = check_uploads(transaction, scene.owner, scene.bytes, owner_bytes); !fits) return fits;
    return transaction.run("INSERT OR REPLACE INTO scenes VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                           std::as_bytes(std::span(scene.id.bytes)), stored.arrival, scene.name, scene.media_type,
                           scene.bytes, scene.sample, created_ms, scene.owner);
  });
  if (!written) {
    // Without a row the next start would sweep it; on a full disk that is late.
    if (known == scenes_.end()) (void)files_->remove(scene.id).ok();
    return written;
  }
  const std::unique_lock copy(copy_);
  next_arrival_ = std::max(next_arrival_, stored.arrival + 1);
  scenes_.insert_or_assign(scene.id, std::move(stored));
  return Done{};
}

std::optional<SceneRecord> Store::scene(const Digest& id) const {
  const std::shared_lock copy(copy_);
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return std::nullopt;
  return found->second;
}

Result<Blob> Store::scene_bytes(const Digest& id) { return read_scene(id, &Blobs::get); }

Result<FileBytes> Store::scene_file(const Digest& id) { return read_scene(id, &Blobs::open_file); }

template <class Bytes>
Result<Bytes> Store::read_scene(const Digest& id, Result<Bytes> (Blobs::*read)(const Digest&)) {
  if (!scene(id)) return Error{ErrorCode::not_found, "there is no scene " + to_hex(id), ""};
  Result<Bytes> bytes = (*files_.*read)(id);
  if (bytes || bytes.error().code != ErrorCode::not_found) return bytes;
  if (const Status removed = remove_scene(id); !removed) return removed.error();
  return Error{ErrorCode::not_found, "the file of scene " + to_hex(id) + " was damaged; upload it again", ""};
}

std::vector<SceneRecord> Store::scenes() const {
  const std::shared_lock copy(copy_);
  std::vector<SceneRecord> ordered;
  for (const auto& [id, scene] : scenes_) ordered.push_back(scene);
  std::sort(ordered.begin(), ordered.end(), [](const SceneRecord& a, const SceneRecord& b) {
    return std::pair(!a.sample, a.arrival) < std::pair(!b.sample, b.arrival);
  });
  return ordered;
}

Status Store::name_scene(const Digest& id, const std::string& name) {
  const std::lock_guard lock(writing_);
  const Status written = database_.write([&](Transaction& transaction) {
    return transaction.run("UPDATE scenes SET name = ? WHERE id = ? AND name = ''", name,
                           std::as_bytes(std::span(id.bytes)));
  });
  if (!written) return written;
  const std::unique_lock copy(copy_);
  const auto scene = scenes_.find(id);
  if (scene != scenes_.end() && scene->second.name.empty()) scene->second.name = name;
  return Done{};
}

Status Store::remove_scene(const Digest& id) {
  const std::lock_guard lock(writing_);
  const Status written = database_.write([&](Transaction& transaction) {
    return transaction.run("DELETE FROM scenes WHERE id = ?", std::as_bytes(std::span(id.bytes)));
  });
  if (!written) return written;
  {
    const std::unique_lock copy(copy_);
    scenes_.erase(id);
  }
  return files_->remove(id);
}

// --- jobs and events ----------------------------------------------------------------------------------------------

/// Ids are reserved by the thousand, in a transaction that waits for the disk: those given since are not given again
/// even where their events were lost with the power.
Status Store::give_id(Transaction& transaction, Event& event) const {
  event.id = last_event_ + 1;
  if (event.id <= reserved_events_) return Done{};
  return transaction.run("UPDATE counters SET value = ? WHERE name = 'events_reserved'", reserved_events_ + kReserved);
}

Status Store::insert_event(Transaction& transaction, Event& event, const StoredJob* job) {
  if (const Status given = give_id(transaction, event); !given) return given;
  if (const auto old = job ? superseded(job->events, event.kind) : std::nullopt) {
    const Status gone = transaction.run("DELETE FROM events WHERE id = ?", job->events[*old].id);
    if (!gone) return gone;
  }
  return transaction.run("INSERT INTO events VALUES (?, ?, ?)", event.id, event.job, event_text(event));
}

Status Store::insert_gone(Transaction& transaction, Event& event) const {
  if (const Status given = give_id(transaction, event); !given) return given;
  if (gone_.size() >= kGoneEvents) {
    const Status dropped = transaction.run("DELETE FROM gone WHERE id = ?", gone_.front().id);
    if (!dropped) return dropped;
  }
  return transaction.run("INSERT INTO gone VALUES (?, ?)", event.id, event_text(event));
}

void Store::keep(StoredJob& job, Event event) {
  if (const auto old = superseded(job.events, event.kind)) {
    job.events.erase(job.events.begin() + static_cast<std::ptrdiff_t>(*old));
  }
  job.events.push_back(std::move(event));
}

Result<Event> Store::add_job(JobRecord& job, Event event, const Database::Body& also) {
  const std::lock_guard lock(writing_);
  if (jobs_.contains(job.id)) return Error{ErrorCode::conflict, "a job of this id exists", ""};
  JobRecord added = job;
  added.sequence = last_sequence_ + 1;
  const Status written = database_.write([&](Transaction& transaction) -> Status {
    Status done = transaction.run("UPDATE counters SET value = ? WHERE name = 'job_sequence'", added.sequence);
    if (done) {
      done = transaction.run("INSERT INTO jobs VALUES (?, ?, ?)", added.id, added.sequence, record_text(added));
    }
    if (done) done = insert_event(transaction, event, nullptr);
    if (done && also) done = also(transaction);
    return done;
  });
  if (!written) return written.error();
  const std::unique_lock copy(copy_);
  job.sequence = last_sequence_ = added.sequence;
  StoredJob& stored = jobs_[job.id];
  stored.record = job;
  note_given(event.id);
  keep(stored, event);
  return event;
}

Result<Event> Store::update_job(const JobRecord& job, Event event) {
  const std::lock_guard lock(writing_);
  const auto found = jobs_.find(job.id);
  if (found == jobs_.end()) return no_job(job.id);
  StoredJob& stored = found->second;
  const bool relaxed = event.kind == EventKind::progress && last_event_ < reserved_events_;
  const auto change = [&](Transaction& transaction) -> Status {
    Status done = transaction.run("UPDATE jobs SET record = ? WHERE id = ?", record_text(job), job.id);
    if (done) done = insert_series(transaction, job, stored.record.series.size());
    if (done) done = insert_event(transaction, event, &stored);
    return done;
  };
  const Status written = database_.write(change, relaxed ? Durability::relaxed : Durability::full);
  if (!written) return written.error();
  const std::unique_lock copy(copy_);
  stored.record = job;
  note_given(event.id);
  keep(stored, event);
  return event;
}

void Store::note_given(std::uint64_t event) {
  if (event > reserved_events_) reserved_events_ += kReserved;
  last_event_ = event;
}

std::optional<JobRecord> Store::job(const std::string& id) const {
  const std::shared_lock copy(copy_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return std::nullopt;
  return found->second.record;
}

std::vector<JobRecord> Store::jobs() const {
  std::vector<JobRecord> records;
  {
    const std::shared_lock copy(copy_);
    for (const auto& [id, job] : jobs_) records.push_back(job.record);
  }
  std::sort(records.begin(), records.end(),
            [](const JobRecord& a, const JobRecord& b) { return a.sequence > b.sequence; });
  return records;
}

Result<Event> Store::remove_job(const std::string& id) {
  const std::lock_guard lock(writing_);
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return no_job(id);
  Event event;
  static_cast<JobNumbers&>(event) = found->second.record;
  event.kind = EventKind::gone;
  event.time = std::chrono::system_clock::now();
  event.job = id;
  const Status written = database_.write([&](Transaction& transaction) {
    const Status done = transaction.run("DELETE FROM jobs WHERE id = ?", id);
    return done ? insert_gone(transaction, event) : done;
  });
  if (!written) return written.error();
  const std::unique_lock copy(copy_);
  jobs_.erase(found);
  note_given(event.id);
  gone_.push_back(event);
  if (gone_.size() > kGoneEvents) gone_.pop_front();
  return event;
}

std::vector<Event> Store::events_after(std::uint64_t after, const std::string& job) const {
  const std::shared_lock copy(copy_);
  std::vector<Event> events;
  const auto collect = [&](const StoredJob& stored) {
    const auto first = std::upper_bound(stored.events.begin(), stored.events.end(), after,
                                        [](std::uint64_t id, const Event& event) { return id < event.id; });
    events.insert(events.end(), first, stored.events.end());
  };
  for (const Event& event : gone_) {
    if (event.id > after && (job.empty() || event.job == job)) events.push_back(event);
  }
  if (!job.empty()) {
    const auto found = jobs_.find(job);
    if (found != jobs_.end()) collect(found->second);
    return events;
  }
  for (const auto& [id, stored] : jobs_) collect(stored);
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.id < b.id; });
  return events;
}

bool Store::is_gone(const std::string& job) const {
  const std::shared_lock copy(copy_);
  return std::any_of(gone_.begin(), gone_.end(), [&job](const Event& event) { return event.job == job; });
}

std::uint64_t Store::newest_event() const {
  const std::shared_lock copy(copy_);
  return last_event_;
}

}  // namespace photond
