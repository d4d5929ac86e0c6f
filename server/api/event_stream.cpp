#include <memory>
#include <set>

#include "server/api/api.h"
#include "server/api/job_message.h"
#include "server/api/problem.h"
#include "server/api/query.h"

namespace photond {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{1000};  // how soon a closed connection is noticed
constexpr std::chrono::seconds kHeartbeat{15};

std::string to_sse(const Event& event) {
  return "id: " + std::to_string(event.id) + "\nevent: " + event_name(event.kind) +
         "\ndata: " + to_text(event_message(event)) + "\n\n";
}

/// One reader's place in the log. Nothing is queued for it: a slow reader finds fewer events, later.
class EventFeed {
 public:
  EventFeed(const Store& store, const Jobs& jobs, std::set<std::string> ids, std::uint64_t after, bool ends,
            std::stop_token stop)
      : store_(store), log_(jobs.events()), jobs_(std::move(ids)), after_(after), ends_(ends), stop_(std::move(stop)) {
    for (const std::string& id : jobs_) {
      if (auto job = jobs.job(id)) watched_.push_back(std::move(job));
    }
  }

  /// The next piece of the stream; no value when it `ends` with its one job and all is told.
  std::optional<std::string> next() {
    if (ended_) return std::nullopt;
    look();
    std::string text;
    if (!greeted_) text = "retry: 2000\nid: " + std::to_string(after_) + "\n\n";
    greeted_ = true;
    const std::uint64_t seen = log_.newest();
    std::vector<Event> events = read();
    if (events.empty() && text.empty() && log_.wait_beyond(seen, kLook, stop_)) events = read();
    for (const Event& event : events) text += to_sse(event);
    if (!events.empty()) after_ = events.back().id;
    ended_ = one_job_ended(events);
    return with_heartbeat(std::move(text));
  }

 private:
  std::vector<Event> read() const {
    std::vector<Event> events = log_.read_after(after_, jobs_.size() == 1 ? *jobs_.begin() : std::string());
    if (jobs_.size() > 1) std::erase_if(events, [this](const Event& e) { return !jobs_.contains(e.job); });
    return events;
  }

  void look() const {
    if (jobs_.empty()) log_.look();
    for (const auto& job : watched_) job->look();
  }

  bool one_job_ended(const std::vector<Event>& events) const {
    if (!ends_) return false;
    if (!events.empty()) return is_terminal(events.back().state);  // also of one that is gone
    return !store_.job(*jobs_.begin());
  }

  std::string with_heartbeat(std::string text) {
    const Clock::time_point now = Clock::now();
    if (text.empty() && now - last_ >= kHeartbeat) text = ": heartbeat\n\n";
    if (!text.empty()) last_ = now;
    return text;
  }

  const Store& store_;
  const EventLog& log_;
  const std::set<std::string> jobs_;  ///< empty: all
  std::vector<std::shared_ptr<const Job>> watched_;
  std::uint64_t after_;
  const bool ends_;
  std::stop_token stop_;
  Clock::time_point last_ = Clock::now();
  bool greeted_ = false;
  bool ended_ = false;
};

/// Where a reader continues: its Last-Event-ID (or the query's `after`), else `fresh`. An id from the future
/// belongs to an earlier life of the service, and says nothing.
std::uint64_t start_of(const Request& request, std::uint64_t newest, std::uint64_t fresh) {
  const Json* id = parameter(request, "Last-Event-ID");
  if (id == nullptr) id = parameter(request, "after");
  if (id == nullptr) return fresh;
  const std::uint64_t after = id->get<std::uint64_t>();
  return after <= newest ? after : 0;
}

Response stream(std::shared_ptr<EventFeed> feed) {
  Response response;
  response.content_type = "text/event-stream";
  response.headers.emplace_back("Cache-Control", "no-store");
  response.headers.emplace_back("X-Accel-Buffering", "no");
  response.body = Pieces([feed = std::move(feed)] { return feed->next(); });
  return response;
}

}  // namespace

Response Api::job_events(const Request& request) const {
  const std::string& id = request.captures[0];
  const EventLog& log = jobs_.events();
  const std::uint64_t after = start_of(request, log.newest(), 0);
  const auto job = store_.job(id);
  if (!job) return no_job(id);
  if (is_terminal(job->state) && log.read_after(after, id).empty()) {
    Response done;  // tells an EventSource to stop asking
    done.status = 204;
    return done;
  }
  return stream(std::make_shared<EventFeed>(store_, jobs_, std::set{id}, after, true, request.stop));
}

Response Api::all_events(const Request& request) const {
  const EventLog& log = jobs_.events();
  const auto jobs = parameter(request, "job")->get<std::set<std::string>>();
  for (const std::string& id : jobs) {
    if (!store_.job(id) && !store_.is_gone(id)) return no_job(id);  // of one that is gone the stream says so
  }
  const std::uint64_t after = start_of(request, log.newest(), jobs.empty() ? log.newest() : 0);
  return stream(std::make_shared<EventFeed>(store_, jobs_, jobs, after, false, request.stop));
}

}  // namespace photond
