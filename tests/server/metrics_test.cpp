#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "tests/server/service_fixture.h"

// /metrics, read by the rules of the Prometheus text format (version 0.0.4), and what it must tell.

namespace photond::test {
namespace {

using Labels = std::map<std::string, std::string>;

struct Metrics {
  std::map<std::string, std::string> types;                      ///< by family
  std::map<std::pair<std::string, Labels>, double> samples;      ///< by name and labels

  double value(const std::string& name, const Labels& labels = {}) const {
    const auto found = samples.find({name, labels});
    return found == samples.end() ? std::nan("") : found->second;
  }
};

/// The family that a sample of this name belongs to.
std::string family_of(const std::string& name, const std::map<std::string, std::string>& types) {
  for (const char* ending : {"_bucket", "_sum", "_count"}) {
    const std::string text(ending);
    if (!name.ends_with(text)) continue;
    const std::string stem = name.substr(0, name.size() - text.size());
    if (const auto found = types.find(stem); found != types.end() && found->second == "histogram") return stem;
  }
  return name;
}

Labels parse_labels(const std::string& text) {
  static const std::regex kLabel(R"re(([a-zA-Z_][a-zA-Z0-9_]*)="((?:[^"\\\n]|\\["\\n])*)"(,|$))re");
  Labels labels;
  std::size_t read = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), kLabel), end; at != end; ++at) {
    EXPECT_EQ(static_cast<std::size_t>(at->position()), read) << text;
    read += static_cast<std::size_t>(at->length());
    EXPECT_TRUE(labels.emplace((*at)[1], (*at)[2]).second) << "a label twice: " << text;
  }
  EXPECT_EQ(read, text.size()) << text;
  return labels;
}

Metrics parse_metrics(const std::string& text) {
  static const std::regex kAnnouncement(R"(# (HELP|TYPE) ([a-zA-Z_:][a-zA-Z0-9_:]*) (.+))");
  static const std::regex kSample(R"(([a-zA-Z_:][a-zA-Z0-9_:]*)(?:\{(.*)\})? ([0-9.e+-]+|NaN|\+Inf|-Inf))");
  Metrics metrics;
  std::set<std::string> helped, closed;
  std::string current;
  EXPECT_TRUE(text.ends_with('\n'));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch part;
    if (std::regex_match(line, part, kAnnouncement)) {
      const std::string family = part[2];
      if (family != current) {
        EXPECT_TRUE(closed.insert(current).second) << current;
        EXPECT_FALSE(closed.contains(family)) << "the lines of a family stand together: " << line;
        current = family;
      }
      if (part[1] == "HELP") {
        EXPECT_TRUE(helped.insert(family).second) << line;
      }
      if (part[1] == "TYPE") {
        EXPECT_TRUE(metrics.types.emplace(family, part[3]).second) << line;
      }
      continue;
    }
    if (!std::regex_match(line, part, kSample)) {
      ADD_FAILURE() << "neither announcement nor sample: " << line;
      continue;
    }
    EXPECT_EQ(family_of(part[1], metrics.types), current) << line;
    const double value = std::stod(part[3]);
    EXPECT_TRUE(metrics.samples.emplace(std::pair(std::string(part[1]), parse_labels(part[2])), value).second) << line;
  }
  for (const auto& [family, type] : metrics.types) {
    EXPECT_TRUE(helped.contains(family)) << family;
    EXPECT_TRUE(type == "counter" || type == "gauge" || type == "histogram") << family;
    EXPECT_EQ(type == "counter", family.ends_with("_total")) << family;
  }
  return metrics;
}

/// Buckets grow, and the last is the count.
void check_histogram(const Metrics& metrics, const std::string& name) {
  std::map<double, double> buckets;
  for (const auto& [key, value] : metrics.samples) {
    if (key.first == name + "_bucket") buckets[std::stod(key.second.at("le"))] = value;
  }
  ASSERT_FALSE(buckets.empty()) << name;
  double before = 0;
  for (const auto& [bound, count] : buckets) {
    EXPECT_GE(count, before) << name << " " << bound;
    before = count;
  }
  EXPECT_TRUE(std::isinf(buckets.rbegin()->first)) << name;
  EXPECT_EQ(before, metrics.value(name + "_count")) << name;
  EXPECT_GE(metrics.value(name + "_sum"), 0) << name;
}

TEST_F(ServiceTest, MetricsFollowTheTextFormatAndTellWhatHappened) {
  wait_for_end(submit(upload(), R"("method":"progressive","stop":{"passes":3})"));
  get(port_, "/v1/jobs/none");
  get(port_, "/a%00");
  const Reply reply = get(port_, "/metrics");
  EXPECT_EQ(reply.headers.at("content-type"), "text/plain; version=0.0.4");
  const Metrics metrics = parse_metrics(reply.body);
  EXPECT_EQ(metrics.value("photond_refusals_total", {{"reason", "not_found"}}), 1);
  EXPECT_EQ(metrics.value("photond_refusals_total", {{"reason", "invalid_request"}}), 1);
  EXPECT_EQ(metrics.value("photond_requests_total", {{"method", "POST"}, {"route", "/v1/jobs"}, {"status", "202"}}), 1);
  EXPECT_EQ(metrics.value("photond_jobs", {{"state", "succeeded"}}), 1);
  EXPECT_EQ(metrics.value("photond_job_moves_total", {{"state", "succeeded"}}), 1);
  EXPECT_EQ(metrics.value("photond_passes_total"), 3);
  EXPECT_EQ(metrics.value("photond_map_cache_misses_total"), 4) << "three maps and their guide";
  EXPECT_EQ(metrics.value("photond_queue_wait_seconds_count"), 1);
  EXPECT_EQ(metrics.value("photond_streams_open"), 0);
  EXPECT_GT(metrics.value("process_open_fds"), 3);
  EXPECT_LT(metrics.value("process_open_fds"), metrics.value("process_max_fds"));
  EXPECT_GT(metrics.value("process_resident_memory_bytes"), 1e6);
  EXPECT_GT(metrics.value("process_cpu_seconds_total"), 0);
  check_histogram(metrics, "photond_queue_wait_seconds");
  check_histogram(metrics, "photond_request_seconds");
}

}  // namespace
}  // namespace photond::test
