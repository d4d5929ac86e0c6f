#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "server/http/server.h"
#include "server/log.h"
#include "tests/server/http_client.h"
#include "tests/support/temporary_folder.h"

// What hostile clients do, over raw sockets. The routes are the test's own: what counts is the transport.

namespace photond::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kLimit = 100'000;

std::vector<Route> test_routes() {
  const auto say = [](auto body) {
    Response response;
    response.content_type = "text/plain";
    response.body = std::move(body);
    return response;
  };
  const Handler peer = [say](const Request& request) { return say(request.peer + " " + request.header("remote_addr")); };
  const Handler size = [say](const Request& request) { return say(std::to_string(request.body.size())); };
  const Handler query = [say](const Request& request) { return say(request.query.contains("q") ? request.query.find("q")->second : "-"); };
  const Handler raise = [](const Request&) -> Response { throw std::runtime_error("secret\r\nX-Evil: 1"); };
  const Handler broken_stream = [say](const Request&) {
    return say(Pieces([first = true]() mutable -> std::optional<std::string> {
      if (!std::exchange(first, false)) throw std::runtime_error("secret");
      return "piece";
    }));
  };
  const Handler stream = [say](const Request&) {
    return say(Pieces([left = 2]() mutable -> std::optional<std::string> {
      if (left-- == 0) return std::nullopt;
      return "piece\n";
    }));
  };
  const Handler large = [say](const Request&) { return say(std::string(64 << 20, 'x')); };
  const Handler endless = [say](const Request&) { return say(Pieces([] { return std::string(1 << 20, 'x'); })); };
  const Handler slow = [say](const Request&) {
    std::this_thread::sleep_for(300ms);
    return say("slow");
  };
  const Admission all = [](Request&) { return std::nullopt; };
  return {{"GET", "/peer", all, peer, {}, 0, Seat::probe},
          {"GET", "/query", all, query},
          {"GET", "/throw", all, raise},
          {"GET", "/stream", all, stream, {}, 0, Seat::stream},
          {"GET", "/broken", all, broken_stream, {}, 0, Seat::stream},
          {"GET", "/slow", all, slow},
          {"GET", "/large", all, large},
          {"GET", "/endless", all, endless, {}, 0, Seat::stream},
          {"POST", "/size", all, size, {"text/plain"}, kLimit, Seat::upload},
          {"POST", "/touch", all, size}};
}

class HttpAttacks : public ::testing::Test {
 protected:
  void SetUp() override { start({}); }

  void start(HttpOptions options) {
    server_.reset();
    options.patience = 400ms;
    auto server = HttpServer::start(options, test_routes(), {}, counts_);
    ASSERT_TRUE(server.ok()) << server.error().message;
    server_ = std::move(*server);
    port_ = server_->port();
  }

  /// Sends `raw`, whole or until the server closes, and returns the bytes of the answer.
  std::string ask(const std::string& raw) const {
    Connection connection(port_);
    connection.send(raw);
    return connection.read_all(10s);
  }
  int status(const std::string& raw) const { return parse_reply(ask(raw)).status; }

  static int answers(const std::string& raw) {
    int count = 0;
    for (std::size_t at = raw.find("HTTP/1.1 "); at != std::string::npos; at = raw.find("HTTP/1.1 ", at + 1)) ++count;
    return count;
  }

  std::uint64_t drops(const std::string& reason) const {
    const auto all = counts_.snapshot().drops;
    const auto found = all.find(reason);
    return found == all.end() ? 0 : found->second;
  }

  RequestCounts counts_;
  std::unique_ptr<HttpServer> server_;
  int port_ = 0;
};

const std::string kUpload = "POST /size HTTP/1.1\r\nHost: x\r\nContent-Type: text/plain\r\n";
const std::string kHidden = "GET /query?q=hidden HTTP/1.1\r\nHost: x\r\n\r\n";

TEST_F(HttpAttacks, HonestRequestsAreAnswered) {
  EXPECT_EQ(get(port_, "/query?q=a%20b%2Bc").body, "a b+c");
  EXPECT_EQ(request(port_, "POST", "/size", std::string(kLimit, 'x'), "text/plain").body, std::to_string(kLimit));
  EXPECT_EQ(parse_reply(ask(kUpload + "Transfer-Encoding: chunked\r\n\r\n" + chunked_body(50, 1000))).body, "50000");
  EXPECT_EQ(parse_reply(ask(kUpload + "Transfer-Encoding: chunked\r\n\r\n5;a=b\r\nabcde\r\n0\r\n\r\n")).body, "5");
  EXPECT_EQ(get(port_, "/stream").body, "piece\npiece\n");
  const std::string asked = ask(kUpload + "Content-Length: 3\r\nExpect: 100-continue\r\n\r\nabc");
  EXPECT_TRUE(asked.starts_with("HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 200")) << asked;
  const std::string head = ask("HEAD /query HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_NE(head.find("Content-Length: 1\r\n"), std::string::npos) << head;
  EXPECT_TRUE(head.ends_with("\r\n\r\n"));
}

TEST_F(HttpAttacks, AnOldClientsStreamIsNotChunked) {
  const std::string raw = ask("GET /stream HTTP/1.0\r\n\r\n");
  EXPECT_EQ(raw.find("chunked"), std::string::npos) << raw;
  EXPECT_TRUE(raw.ends_with("\r\n\r\npiece\npiece\n")) << raw;
}

TEST_F(HttpAttacks, BodiesBeyondTheLimitAreRefusedHoweverTheyAreSent) {
  const std::string big(20 << 20, 'x');
  EXPECT_EQ(status(kUpload + "Content-Length: " + std::to_string(big.size()) + "\r\n\r\n" + big), 413)
      << "heard though the client sends on";
  EXPECT_EQ(status(kUpload + "Transfer-Encoding: chunked\r\n\r\n" + chunked_body(20'000, 1000)), 413);
  EXPECT_EQ(status(kUpload + "Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\nx"), 413);
  EXPECT_EQ(status(kUpload + "Content-Length: 999999999999999999\r\n\r\nx"), 413);
  EXPECT_EQ(status(kUpload + "Content-Length: 10\r\nContent-Encoding: gzip\r\n\r\n0123456789"), 415);
  EXPECT_EQ(status(kUpload + "Content-Length: 200000\r\nExpect: 100-continue\r\n\r\n"), 413) << "before it is sent";
}

TEST_F(HttpAttacks, ABrokenChunkedCodingIsRefused) {
  for (const char* body : {"5\nabcde\r\n0\r\n\r\n", "5\r\nabcdefgh\r\n0\r\n\r\n", "x\r\n", "-5\r\nabcde\r\n", "0x5\r\nabcde\r\n",
                           " 5\r\nabcde\r\n", "5\r\nabcde\r\n0\r\nTrailer: 1\r\n\r\n", "\r\n", "11111111111111111\r\n"}) {
    const std::string raw = ask(kUpload + "Transfer-Encoding: chunked\r\n\r\n" + body);
    EXPECT_EQ(parse_reply(raw).status, 400) << body;
    EXPECT_EQ(answers(raw), 1) << body;
  }
  EXPECT_EQ(status(kUpload + "Transfer-Encoding: chunked\r\n\r\n5;" + std::string(1 << 20, 'a')), 400) << "endless line";
}

TEST_F(HttpAttacks, EndlessHeadersEnd) {
  std::string lines;
  for (int i = 0; i < 200'000; ++i) lines += "A: 1\r\n";
  EXPECT_EQ(status("GET /peer HTTP/1.1\r\nHost: x\r\n" + lines + "\r\n"), 431);
  EXPECT_EQ(status("GET /peer HTTP/1.1\r\nHost: x\r\nA: " + std::string(10 << 20, 'a')), 431);
  EXPECT_EQ(status("GET /" + std::string(10 << 20, 'a')), 431);
  EXPECT_EQ(status("GET /" + std::string(5'000, 'a') + " HTTP/1.1\r\nHost: x\r\n\r\n"), 414);
}

TEST_F(HttpAttacks, DawdlersAreShownOut) {
  for (const std::string& begin : {std::string("GET /peer HTTP/1.1\r\n"), kUpload + "Content-Length: 1000\r\n\r\n", std::string()}) {
    Connection slow(port_);
    const Clock::time_point start_time = Clock::now();
    slow.send(begin);
    // A byte now and then must not buy time.
    while (!slow.closed() && Clock::now() - start_time < 5s) {
      slow.send("a");
      slow.read_until("", 100ms);
    }
    EXPECT_TRUE(slow.closed()) << begin;
    EXPECT_TRUE(slow.read_all().starts_with("HTTP/1.1 408 ")) << begin;
    EXPECT_LT(Clock::now() - start_time, 3s) << begin << "400 ms, a look every 250 ms, and a slow machine";
  }
  EXPECT_EQ(drops("slow"), 3u);
}

TEST_F(HttpAttacks, DawdlersKeepNobodyFromBeingServed) {
  HttpOptions options;
  options.seats = {1, 1, 1};  // threads for three requests, and the spare ones
  start(options);
  std::vector<std::unique_ptr<Connection>> crowd;
  for (int i = 0; i < 400; ++i) {
    crowd.push_back(std::make_unique<Connection>(port_));
    crowd.back()->send(i % 2 == 0 ? "GET /peer HT" : kUpload + "Content-Length: 1000\r\n\r\nx");
  }
  EXPECT_EQ(get(port_, "/query").status, 200);
}

TEST_F(HttpAttacks, ASlowClientsPlaceIsNotAnothersButHealthIsAlwaysTold) {
  HttpOptions options;
  options.seats = {1, 1, 1};
  start(options);
  Connection busy(port_);
  busy.send("GET /slow HTTP/1.1\r\nHost: x\r\n\r\n");
  std::this_thread::sleep_for(100ms);
  const Reply refused = get(port_, "/query");
  EXPECT_EQ(refused.status, 503);
  EXPECT_EQ(refused.headers.count("retry-after"), 1u);
  EXPECT_EQ(get(port_, "/peer").status, 200);
  EXPECT_EQ(counts_.snapshot().refusals.at("too_many_requests"), 1u);
  EXPECT_EQ(parse_reply(busy.read_all()).status, 200);
}

TEST_F(HttpAttacks, NothingFromARequestGetsIntoHeaders) {
  for (const char* id : {"a%0d%0aX-Evil: 1", "a b", "\"", "<script>", "a\tb"}) {
    const Reply reply = get(port_, "/peer", {{"X-Request-Id", id}});
    EXPECT_EQ(reply.headers.count("x-evil"), 0u) << id;
    EXPECT_NE(reply.headers.at("x-request-id"), id);
    EXPECT_EQ(reply.headers.at("x-request-id").size(), 16u) << id;
  }
  EXPECT_EQ(get(port_, "/peer", {{"X-Request-Id", "trace-1.2_3"}}).headers.at("x-request-id"), "trace-1.2_3");
  EXPECT_EQ(get(port_, "/peer%0d%0aX-Evil:%201").headers.count("x-evil"), 0u);
}

TEST_F(HttpAttacks, TheAddressIsTheConnectionsOwn) {
  EXPECT_EQ(get(port_, "/peer", {{"REMOTE_ADDR", "6.6.6.6"}}).body, "127.0.0.1 6.6.6.6") << "a header is but a header";
}

TEST_F(HttpAttacks, PathTricksFindNothing) {
  for (const char* path : {"/../peer", "/%2e%2e/peer", "/peer/", "//peer", "/./peer", "/peer%2f", "/PEER"}) {
    EXPECT_EQ(get(port_, path).status, 404) << path;
  }
  for (const char* path : {"/peer%00", "http://127.0.0.1/peer", "*", "peer", "/peer#x"}) {
    EXPECT_EQ(get(port_, path).status, 400) << path;
  }
  EXPECT_EQ(get(port_, "/%70eer").status, 200) << "the same path by another spelling";
}

TEST_F(HttpAttacks, ExceptionsTellNothingAndEndNothing) {
  const std::string raw = ask("GET /throw HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(parse_reply(raw).status, 500);
  EXPECT_EQ(raw.find("secret"), std::string::npos) << raw;
  EXPECT_EQ(raw.find("X-Evil"), std::string::npos) << raw;
  const std::string broken = ask("GET /broken HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_NE(broken.find("piece"), std::string::npos);
  EXPECT_EQ(broken.find("\r\n0\r\n\r\n"), std::string::npos) << "the client must see that the end is missing";
  EXPECT_EQ(get(port_, "/peer").status, 200);
}

TEST_F(HttpAttacks, ARequestInABodyIsNoRequest) {
  const std::string length = "Content-Length: " + std::to_string(kHidden.size()) + "\r\n";
  const std::string all[] = {"GET /peer HTTP/1.1\r\nHost: x\r\n" + length + "\r\n" + kHidden,
                             "POST /touch HTTP/1.1\r\nHost: x\r\n" + length + "\r\n" + kHidden,
                             "POST /nothing HTTP/1.1\r\nHost: x\r\n" + length + "\r\n" + kHidden,
                             "DELETE /peer HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n" + kHidden,
                             kUpload + "Content-Length: 1\r\n\r\nx" + kHidden,
                             "GET /peer HTTP/1.1\r\nHost: x\r\nConnection: keep-alive\r\n\r\n" + kHidden,
                             kUpload + length + "Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n" + kHidden,
                             kUpload + "Content-Length: 0\r\n" + length + "\r\n" + kHidden,
                             kUpload + "Transfer-Encoding: chunked, identity\r\n\r\n0\r\n\r\n" + kHidden,
                             kUpload + "Transfer-Encoding : chunked\r\n\r\n0\r\n\r\n" + kHidden};
  for (const std::string& raw : all) {
    const std::string answer = ask(raw);
    EXPECT_EQ(answers(answer), 1) << raw << "\n" << answer;
    EXPECT_EQ(answer.find("hidden"), std::string::npos) << raw;
    EXPECT_NE(answer.find("Connection: close"), std::string::npos) << raw;
  }
}

TEST_F(HttpAttacks, TheLogNamesRequestsAndTellsNoSecrets) {
  const TemporaryFolder folder;
  std::FILE* file = std::fopen(folder.file("log").c_str(), "w");
  begin_log(LogLevel::debug, file);
  request(port_, "POST", "/size?key=secret-in-query", "secret-body", "text/plain",
          {{"Authorization", "Bearer secret-key"}, {"X-Request-Id", "trace-1"}, {"Cookie", "secret-cookie"}});
  get(port_, "/nothing\"%22%5c", {{"X-Request-Id", "trace-2"}});
  get(port_, "/throw");
  server_->stop();
  end_log();
  std::fclose(file);
  std::ifstream in(folder.file("log"));
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(text.find("secret-"), std::string::npos) << text;
  std::istringstream lines(text);
  std::map<std::string, nlohmann::json> by_id;
  for (std::string line; std::getline(lines, line);) {
    const auto json = nlohmann::json::parse(line);
    by_id[json["event"] == "exception" ? "exception" : json["request"].get<std::string>()] = json;
  }
  EXPECT_EQ(by_id["trace-1"]["status"], 200);
  EXPECT_EQ(by_id["trace-1"]["route"], "/size");
  EXPECT_EQ(by_id["trace-1"]["peer"], "127.0.0.1");
  EXPECT_EQ(by_id["trace-1"]["complete"], true);
  EXPECT_EQ(by_id["trace-2"]["refusal"], "not_found");
  EXPECT_EQ(by_id["exception"]["what"], "secret\r\nX-Evil: 1") << "operators may know what clients may not";
}

/// These take as long as a client's grace does.
using HttpTricklesStatistical = HttpAttacks;

TEST_F(HttpTricklesStatistical, ALargeBodyThatTricklesIsGivenUp) {
  Connection slow(port_);
  const Clock::time_point begin = Clock::now();
  slow.send(kUpload + "Transfer-Encoding: chunked\r\n\r\n");
  while (!slow.closed() && Clock::now() - begin < 40s) {
    slow.send("1\r\nx\r\n");
    slow.read_until("", 200ms);
  }
  EXPECT_EQ(parse_reply(slow.read_all()).status, 400);
  EXPECT_GT(Clock::now() - begin, Pace::kGrace - 1s) << "but not before its time";
  EXPECT_LT(Clock::now() - begin, Pace::kGrace + 10s) << "5 s to be seen out, and a slow machine";
}

TEST_F(HttpTricklesStatistical, AnAnswerThatNobodyReadsIsGivenUp) {
  HttpOptions options;
  options.seats = {1, 1, 1};
  start(options);
  Connection stuck(port_);
  stuck.send("GET /large HTTP/1.1\r\nHost: x\r\n\r\n");
  std::this_thread::sleep_for(1s);
  EXPECT_EQ(get(port_, "/query").status, 503) << "the only seat is taken";
  std::this_thread::sleep_for(Pace::kGrace + 2s);
  EXPECT_EQ(get(port_, "/query").status, 200);
}

TEST_F(HttpTricklesStatistical, AViewerThatTakesNothingForFifteenSecondsIsGivenUp) {
  HttpOptions options;
  options.seats = {1, 1, 1};
  start(options);
  Connection stuck(port_);
  stuck.send("GET /endless HTTP/1.1\r\nHost: x\r\n\r\n");
  std::this_thread::sleep_for(1s);
  EXPECT_EQ(get(port_, "/stream").status, 503) << "the only seat is taken";
  std::this_thread::sleep_for(17s);
  EXPECT_EQ(get(port_, "/stream").status, 200);
}

TEST_F(HttpAttacks, NoTwoServersShareAPort) {
  HttpOptions options;
  options.port = port_;
  RequestCounts counts;
  const auto second = HttpServer::start(options, test_routes(), {}, counts);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find("in use"), std::string::npos) << second.error().message;
}

TEST_F(HttpAttacks, AClientThatNeverReadsEndsWithTheServer) {
  Connection stuck(port_, true);
  stuck.send("GET /endless HTTP/1.1\r\nHost: x\r\n\r\n");
  stuck.read_until("xxx", 5s);  // the rest of the first piece is on its way
  Connection waiting(port_);
  waiting.send("GET /pe");
  const Clock::time_point begin = Clock::now();
  server_->stop();
  EXPECT_LT(Clock::now() - begin, 8s) << "answers on their way have 5 s";
  EXPECT_FALSE(Connection(port_).connected());
}

}  // namespace
}  // namespace photond::test
