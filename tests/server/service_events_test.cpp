#include <algorithm>
#include <sstream>
#include <thread>

#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

struct SseEvent {
  std::uint64_t id = 0;
  std::string name;
  json data;
};

/// The events of a stream's text; comments and the greeting carry none.
std::vector<SseEvent> parse_events(const std::string& text) {
  std::vector<SseEvent> events;
  std::istringstream lines(text);
  SseEvent event;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("id: ")) event.id = std::stoull(line.substr(4));
    if (line.starts_with("event: ")) event.name = line.substr(7);
    if (line.starts_with("data: ")) event.data = json::parse(line.substr(6));
    if (!line.empty()) continue;
    if (!event.name.empty()) events.push_back(event);
    event = {};
  }
  return events;
}

std::vector<std::string> states_of(const std::vector<SseEvent>& events) {
  std::vector<std::string> states;
  for (const SseEvent& event : events) {
    if (event.name == "state") states.push_back(event.data["state"]);
  }
  return states;
}

std::string stream_head(const std::string& target) {
  return "GET " + target + " HTTP/1.1\r\nHost: localhost\r\nAccept: text/event-stream\r\n\r\n";
}

TEST_F(ServiceTest, AJobsStreamTellsItsLifeAndEndsWithIt) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"passes":6})");
  const Reply reply = get(port_, "/v1/jobs/" + id + "/events");
  EXPECT_EQ(reply.headers.at("content-type"), "text/event-stream");
  EXPECT_EQ(reply.headers.at("cache-control"), "no-store");
  EXPECT_EQ(reply.headers.at("x-accel-buffering"), "no");
  const auto events = parse_events(reply.body);
  const std::vector<std::string> way{"queued", "preparing", "rendering", "finalizing", "succeeded"};
  EXPECT_EQ(states_of(events), way);
  EXPECT_TRUE(std::any_of(events.begin(), events.end(), [](const SseEvent& e) { return e.name == "frame"; }));
  EXPECT_TRUE(std::is_sorted(events.begin(), events.end(), [](auto& a, auto& b) { return a.id < b.id; }));
  EXPECT_EQ(events.back().data["passes"], 6);
  EXPECT_EQ(events.back().data["job"], id);
}

TEST_F(ServiceTest, LastEventIdContinuesWhereTheReaderWas) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"passes":4})");
  wait_for_end(id);
  const std::string target = "/v1/jobs/" + id + "/events";
  const auto all = parse_events(get(port_, target).body);
  ASSERT_GE(all.size(), 5u);
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    const auto rest = parse_events(get(port_, target, {{"Last-Event-ID", std::to_string(all[i].id)}}).body);
    ASSERT_EQ(rest.size(), all.size() - i - 1);
    EXPECT_EQ(rest.front().id, all[i + 1].id);
  }
  const std::string last = std::to_string(all.back().id);
  EXPECT_EQ(get(port_, target, {{"Last-Event-ID", last}}).status, 204) << "an EventSource must stop asking";
  EXPECT_EQ(get(port_, target + "?after=" + last).status, 204);
  EXPECT_EQ(get(port_, target, {{"Last-Event-ID", "99999"}}).status, 200) << "an id of an earlier service";
  EXPECT_EQ(get(port_, target, {{"Last-Event-ID", "x\r\ny"}}).status, 400);
  EXPECT_EQ(get(port_, target, {{"Last-Event-ID", ""}}).status, 400);
  EXPECT_EQ(get(port_, "/v1/jobs/none/events").status, 404);
}

TEST_F(ServiceTest, TheStreamOfAllTellsOfNewJobsOfSomeOnlyOfThem) {
  const std::string scene = upload();
  const std::string old = submit(scene, R"("method":"path","stop":{"passes":1})");
  wait_for_end(old);
  Connection all(port_);
  all.send(stream_head("/v1/events"));
  all.read_until("retry", 5s);
  const std::string id = submit(scene, R"("method":"path","stop":{"passes":1})");
  const std::string heard = all.read_until("\"state\":\"succeeded\"", 10s);
  EXPECT_NE(heard.find(id), std::string::npos);
  EXPECT_EQ(heard.find(old), std::string::npos);
  EXPECT_FALSE(all.closed());
  Connection some(port_);
  some.send(stream_head("/v1/events?job=" + old + "&job=" + old));
  EXPECT_EQ(some.read_until("\"state\":\"succeeded\"", 10s).find(id), std::string::npos);
  EXPECT_EQ(get(port_, "/v1/events?job=none").status, 404);
}

TEST_F(ServiceTest, StreamsSayOfAJobThatItIsGone) {
  const std::string scene = upload();
  const std::string id = submit(scene, R"("method":"path","stop":{"passes":1})");
  const std::string stays = submit(scene, R"("method":"path","stop":{"passes":1})");
  wait_for_end(id);
  wait_for_end(stays);
  Connection all(port_), some(port_), other(port_);
  all.send(stream_head("/v1/events"));
  some.send(stream_head("/v1/events?job=" + id + "&job=" + stays));
  other.send(stream_head("/v1/events?job=" + stays));
  all.read_until("retry", 5s);
  const auto before = parse_events(get(port_, "/v1/jobs/" + id + "/events").body).back();
  ASSERT_EQ(request(port_, "DELETE", "/v1/jobs/" + id).status, 204);
  const std::string gone = "event: gone\ndata: {\"job\":\"" + id;
  EXPECT_NE(all.read_until(gone, 5s).find(gone), std::string::npos);
  EXPECT_NE(some.read_until(gone, 5s).find(gone), std::string::npos);
  EXPECT_EQ(other.read_until("event: gone", 300ms).find("event: gone"), std::string::npos);
  EXPECT_EQ(get(port_, "/v1/jobs/" + id + "/events").status, 404);
  restart();
  for (const std::string& jobs : {std::string(), "?job=" + id + "&job=" + stays}) {
    Connection late(port_);
    late.send("GET /v1/events" + jobs + " HTTP/1.1\r\nHost: localhost\r\nLast-Event-ID: " + std::to_string(before.id) +
              "\r\n\r\n");
    EXPECT_NE(late.read_until(gone, 5s).find(gone), std::string::npos) << "whoever was away hears of it, too";
  }
}

TEST_F(ServiceTest, StreamsSayOfTheOldestJobThatItIsGone) {
  ServiceOptions options;
  options.max_kept_jobs = 1;
  start(options);
  const std::string scene = upload();
  Connection all(port_);
  all.send(stream_head("/v1/events"));
  all.read_until("retry", 5s);
  std::string first;
  for (int i = 0; i < 3; ++i) {
    const std::string id = submit(scene, R"("method":"path","stop":{"passes":1})");
    wait_for_end(id);
    if (i == 0) first = id;
  }
  const std::string gone = "event: gone\ndata: {\"job\":\"" + first;
  EXPECT_NE(all.read_until(gone, 5s).find(gone), std::string::npos);
}

TEST_F(ServiceTest, EightOpenStreamsDoNotKeepOthersFromBeingServed) {
  const std::string id =
      submit(upload(), R"("method":"path","film":{"width":300,"height":300},"stop":{"seconds":60})");
  std::vector<std::unique_ptr<Connection>> streams;
  for (int i = 0; i < 8; ++i) {
    streams.push_back(std::make_unique<Connection>(port_));
    streams.back()->send(stream_head("/v1/jobs/" + id + "/events"));
    EXPECT_NE(streams.back()->read_until("event: state", 5s).find("event: state"), std::string::npos);
  }
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(get(port_, "/healthz").status, 200);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
  EXPECT_NE(get(port_, "/metrics").body.find("photond_streams_open 8\n"), std::string::npos);
  streams.clear();
  std::string metrics;
  for (int i = 0; i < 100 && metrics.find("photond_streams_open 0\n") == std::string::npos; ++i) {
    std::this_thread::sleep_for(50ms);
    metrics = get(port_, "/metrics").body;
  }
  EXPECT_NE(metrics.find("photond_streams_open 0\n"), std::string::npos) << "closed streams must be noticed";
}

TEST_F(ServiceTest, MoreStreamsThanAdvertisedAreRefused) {
  ServiceOptions options;
  options.max_streams = 2;
  start(options);
  Connection a(port_), b(port_);
  for (Connection* stream : {&a, &b}) {
    stream->send(stream_head("/v1/events"));
    stream->read_until("retry", 5s);
  }
  const Reply refused = get(port_, "/v1/events");
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(refused.headers.count("retry-after"), 1u);
  EXPECT_EQ(get(port_, "/v1/jobs?wait=5").status, 503) << "a long poll takes a stream's place";
  EXPECT_EQ(get(port_, "/healthz").status, 200);
  EXPECT_NE(get(port_, "/metrics").body.find("photond_refusals_total{reason=\"too_many_streams\"} 2\n"), std::string::npos);
}

TEST_F(ServiceTest, AReaderThatDoesNotReadDelaysNobody) {
  const std::string scene = upload();
  Connection stuck(port_, true);
  stuck.send(stream_head("/v1/events"));
  stuck.read_until("retry", 5s);
  const auto begin = std::chrono::steady_clock::now();
  constexpr std::size_t kJobs = 40;
  std::string last;
  for (std::size_t i = 0; i < kJobs; ++i) last = submit(scene, R"("method":"path","stop":{"passes":1})");
  EXPECT_EQ(wait_for_end(last)["state"], "succeeded");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 12s) << "until a stuck reader is given up";
  const std::string told = parse_reply(stuck.read_all(1s)).body;
  EXPECT_GT(told.size(), 50'000u) << "more than the system holds between a narrow reader and the service";
  const auto states = states_of(parse_events(told));
  EXPECT_EQ(static_cast<std::size_t>(std::count(states.begin(), states.end(), "succeeded")), kJobs)
      << "state changes are never lost";
}

TEST_F(ServiceTest, ALongPollWhoseClientHasGoneGivesItsPlaceBack) {
  ServiceOptions options;
  options.max_streams = 2;
  start(options);
  const std::string id = submit(upload(), R"("method":"path","stop":{"passes":1})");
  wait_for_end(id);
  const std::string etag = get(port_, "/v1/jobs/" + id).headers.at("etag");
  for (int i = 0; i < 2; ++i) {
    Connection client(port_);
    client.send("GET /v1/jobs/" + id + "?wait=20 HTTP/1.1\r\nHost: localhost\r\nIf-None-Match: " + etag + "\r\n\r\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  int status = 503;
  for (int i = 0; i < 150 && status == 503; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    status = get(port_, "/v1/jobs/" + id + "?wait=0").status;
  }
  EXPECT_EQ(status, 200);
}

}  // namespace
}  // namespace photond::test
