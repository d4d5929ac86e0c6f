#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "server/api/api.h"
#include "server/jobs/job.h"
#include "server/log.h"

namespace photond {

namespace {

/// Writes the Prometheus text format: each metric is announced once, before its first sample.
class MetricsText {
 public:
  void announce(const char* name, const char* type, const char* help) {
    text_ << "# HELP " << name << ' ' << help << "\n# TYPE " << name << ' ' << type << '\n';
  }
  template <class Value>
  void sample(const std::string& name, const std::string& labels, Value value) {
    text_ << name << labels << ' ' << value << '\n';
  }
  template <class Value>
  void single(const char* name, const char* type, const char* help, Value value) {
    announce(name, type, help);
    sample(name, "", value);
  }
  void counts_by(const char* label, const char* name, const char* help, const std::map<std::string, std::uint64_t>& counts) {
    announce(name, "counter", help);
    for (const auto& [value, count] : counts) sample(name, std::string("{") + label + "=\"" + value + "\"}", count);
  }
  template <std::size_t N>
  void histogram(const std::string& name, const char* help, const Histogram<N>& histogram) {
    announce(name.c_str(), "histogram", help);
    std::uint64_t total = 0;
    for (std::size_t i = 0; i <= N; ++i) {
      total += histogram.counts[i];
      std::ostringstream bound;
      if (i < N) bound << histogram.seconds_up_to[i];
      sample(name + "_bucket", "{le=\"" + (i < N ? bound.str() : "+Inf") + "\"}", total);
    }
    sample(name + "_sum", "", histogram.sum);
    sample(name + "_count", "", total);
  }
  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
};

void write_requests(MetricsText& out, const RequestCounts::Snapshot& counts) {
  out.announce("photond_requests_total", "counter", "Answered requests.");
  for (const auto& [key, count] : counts.answers) {
    const auto& [method, route, status] = key;
    out.sample("photond_requests_total",
               "{method=\"" + method + "\",route=\"" + route + "\",status=\"" + std::to_string(status) + "\"}",
               count);
  }
  out.counts_by("reason", "photond_refusals_total", "Answers that were problems, by the problem's code.", counts.refusals);
  out.counts_by("reason", "photond_dropped_connections_total", "Connections ended without an answer.", counts.drops);
  out.histogram("photond_request_seconds", "Time until an answer begins to leave, long polls included.", counts.seconds);
  out.single("photond_streams_open", "gauge", "Event streams and long polls open now.", counts.streams);
}

void write_jobs(MetricsText& out, const std::vector<JobRecord>& jobs, const JobCounts::Snapshot& counts) {
  std::uint64_t by_state[kJobStates] = {};
  for (const JobRecord& job : jobs) ++by_state[static_cast<int>(job.state)];
  out.announce("photond_jobs", "gauge", "Known jobs by state.");
  for (int i = 0; i < kJobStates; ++i) {
    out.sample("photond_jobs", std::string("{state=\"") + state_name(static_cast<JobState>(i)) + "\"}",
               by_state[i]);
  }
  std::map<std::string, std::uint64_t> moves;
  for (const auto& [state, count] : counts.moves) moves[state_name(state)] = count;
  out.counts_by("state", "photond_job_moves_total", "Moves of jobs into a state.", moves);
  out.histogram("photond_queue_wait_seconds", "Time of jobs in the queue.", counts.queue_wait);
}

void write_maps(MetricsText& out, const MapCache& maps) {
  const MapCache::Totals totals = maps.totals();
  const char* const memory = "{tier=\"memory\"}";
  const char* const disk = "{tier=\"disk\"}";
  const auto both = [&](const char* name, const char* type, const char* help, std::uint64_t in_memory,
                        std::uint64_t on_disk) {
    out.announce(name, type, help);
    out.sample(name, memory, in_memory);
    out.sample(name, disk, on_disk);
  };
  both("photond_map_cache_hits_total", "counter", "Photon maps and guides found in the cache.", totals.memory.hits,
       totals.disk_hits);
  out.single("photond_map_cache_misses_total", "counter", "Photon maps and guides that had to be built.",
             totals.misses);
  both("photond_map_cache_evictions_total", "counter", "Photon maps and guides dropped for room.",
       totals.memory.evictions, totals.disk.evictions);
  both("photond_map_cache_bytes", "gauge", "Size of the cached photon maps and guides.", totals.memory.bytes,
       totals.disk.bytes);
  both("photond_map_cache_entries", "gauge", "Cached photon maps and guides.", totals.memory.entries,
       totals.disk.entries);
  both("photond_map_cache_budget_bytes", "gauge", "What the cached photon maps and guides may take.",
       maps.memory_budget(), maps.disk_budget());
  out.single("photond_map_cache_write_failures_total", "counter", "Photon maps that could not be written to disk.",
             totals.write_failures);
  out.single("photond_map_cache_damaged_total", "counter", "Files of photon maps that were damaged, and dropped.",
             totals.damaged);
}

/// By the names that Prometheus' own clients use.
void write_process(MetricsText& out) {
  std::error_code failed;
  const auto begin = std::filesystem::directory_iterator("/proc/self/fd", failed);
  out.single("process_open_fds", "gauge", "Open descriptors.", std::distance(begin, {}) - 1);  // without this listing
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  out.single("process_max_fds", "gauge", "Descriptors that may be open.", files.rlim_cur);
  std::uint64_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  out.single("process_resident_memory_bytes", "gauge", "Memory in use.",
             resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)));
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  out.single("process_cpu_seconds_total", "counter", "Processor time.", seconds(used.ru_utime) + seconds(used.ru_stime));
  out.single("photond_lost_log_lines_total", "counter", "Log lines dropped because nobody read them.", lost_log_lines());
}

}  // namespace

Response Api::metrics(const Request&) const {
  MetricsText out;
  write_requests(out, counts_.snapshot());
  write_jobs(out, store_.jobs(), jobs_.events().counts());
  const DiskUse disk = jobs_.room().use();
  out.single("photond_disk_used_bytes", "gauge", "Size of the data directory.", disk.used);
  out.single("photond_disk_limit_bytes", "gauge", "What the data directory may take.", disk.limit);
  out.single("photond_disk_full", "gauge", "1 while the disk is full or jobs have no room on it.",
             jobs_.room().full() || jobs_.without_room() > 0 ? 1 : 0);
  out.single("photond_disk_unreachable", "gauge", "1 while the data directory cannot be used.",
             jobs_.room().found() ? 0 : 1);
  out.single("photond_jobs_without_room", "gauge", "Jobs that wait for room on the disk, or go on without.",
             jobs_.without_room());
  out.single("photond_passes_total", "counter", "Rendered passes.", jobs_.passes());
  write_maps(out, jobs_.maps());
  write_process(out);
  Response response;
  response.content_type = "text/plain; version=0.0.4";
  response.headers.emplace_back("Cache-Control", "no-store");
  response.body = out.text();
  return response;
}

}  // namespace photond
