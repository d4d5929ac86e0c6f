#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

/// Sends `raw` and returns the answer.
Reply send_raw(int port, const std::string& raw) {
  Connection connection(port);
  connection.send(raw);
  return parse_reply(connection.read_all());
}

std::string upload_head(const std::string& fields) {
  return "POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Type: model/gltf-binary\r\n" + fields + "\r\n";
}

TEST_F(ServiceTest, TellsOfItself) {
  EXPECT_EQ(get(port_, "/healthz").body, "ok\n");
  EXPECT_EQ(get(port_, "/readyz").status, 200);
  const json info = json::parse(get(port_, "/v1/info").body);
  EXPECT_EQ(info["version"], PHOTOND_VERSION);
  EXPECT_EQ(info["threads"], 2);
  EXPECT_GT(info["limits"]["max_upload_bytes"].get<std::uint64_t>(), 0u);
  EXPECT_EQ(request(port_, "HEAD", "/healthz").body, "");
  EXPECT_EQ(request(port_, "HEAD", "/healthz").headers.at("accept-ranges"), "none") << "as GET of it has none";
}

TEST_F(ServiceTest, TheContractDescribesEveryRouteThatAnswers) {
  const json contract = json::parse(get(port_, "/v1/openapi.json").body);
  EXPECT_EQ(contract["openapi"], "3.1.0");
  for (const auto& [path, operations] : contract["paths"].items()) {
    std::string target = path;
    const std::pair<std::string, std::string> samples[] = {
        {"{rev}", "1"}, {"{format}", "png"}, {"{id}", "none"}, {"{key}", "none"}};
    for (const auto& [name, value] : samples) {
      if (const auto at = target.find(name); at != std::string::npos) target.replace(at, name.size(), value);
    }
    if (target.find("events") != std::string::npos && target.find("none") == std::string::npos)
      continue;  // endless
    for (const auto& [method, operation] : operations.items()) {
      const Reply reply = request(port_,
                                  method == "get"    ? "GET"
                                  : method == "post" ? "POST"
                                                     : "DELETE",
                                  target);
      const bool found = reply.status != 405 && reply.body.find("nothing at this path") == std::string::npos;
      EXPECT_TRUE(found) << method << " " << target << " " << reply.status;
      EXPECT_LT(reply.status, 500);
      const bool documented = operation["responses"].contains(std::to_string(reply.status));
      EXPECT_TRUE(documented) << method << " " << target << " " << reply.status;
    }
  }
}

TEST_F(ServiceTest, UnknownPathsAndMethodsAreProblems) {
  const Reply none = get(port_, "/v1/nothing");
  EXPECT_EQ(none.status, 404);
  EXPECT_EQ(none.headers.at("content-type"), "application/problem+json");
  EXPECT_EQ(none.headers.at("x-content-type-options"), "nosniff");
  const Reply method = request(port_, "DELETE", "/v1/jobs");
  EXPECT_EQ(method.status, 405);
  EXPECT_EQ(method.headers.at("allow"), "POST, GET, HEAD");
  EXPECT_EQ(request(port_, "PUT", "/v1/jobs", "{}", "application/json").status, 405);
  EXPECT_EQ(get(port_, "/" + std::string(2000, 'a')).status, 414);
  EXPECT_EQ(get(port_, "/v1/jobs%0d%0aX:%20y").status, 400);
  EXPECT_EQ(send_raw(port_, "NONSENSE\r\n\r\n").status, 400);
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/x/cancel", "", "", {{"Sec-Fetch-Site", "cross-site"}}).status,
            403);
  Fields many(150, {"X-Many", "1"});
  EXPECT_EQ(get(port_, "/healthz", many).status, 431);
}

TEST_F(ServiceTest, BodiesAreLimitedHoweverTheyAreSent) {
  ServiceOptions options;
  options.max_upload_bytes = 100'000;
  options.patience = 300ms;
  start(options);
  const std::string big(200'000, 'x');
  EXPECT_EQ(request(port_, "POST", "/v1/scenes", big, "model/gltf-binary").status, 413);
  EXPECT_EQ(send_raw(port_, upload_head("Transfer-Encoding: chunked\r\n") + chunked_body(200, 1000)).status,
            413);
  const std::string length = "Content-Length: 10\r\n";
  const std::string body(10, 'x');
  EXPECT_EQ(send_raw(port_, upload_head(length + "Content-Encoding: gzip\r\n") + body).status, 415);
  EXPECT_EQ(send_raw(port_, upload_head(length + "Content-Encoding: br\r\n") + body).status, 415);
  EXPECT_EQ(send_raw(port_, upload_head(length + "Transfer-Encoding: chunked\r\n") + body).status, 400);
  EXPECT_EQ(send_raw(port_, upload_head(length + length) + body).status, 400);
  EXPECT_EQ(send_raw(port_, upload_head("Content-Length: ten\r\n") + body).status, 400);
  EXPECT_EQ(send_raw(port_, upload_head("")).status, 411);
  EXPECT_EQ(send_raw(port_, upload_head(length)).status, 408) << "the body never comes";
  EXPECT_EQ(request(port_, "POST", "/v1/scenes", "--b\r\n\r\n--b--", "multipart/form-data; boundary=b").status,
            415);
  const std::string first_asks = upload_head("Content-Length: 200000\r\nExpect: 100-continue\r\n");
  EXPECT_EQ(send_raw(port_, first_asks).status, 413) << "refused before it is sent";
  EXPECT_EQ(send_raw(port_, upload_head("Transfer-Encoding: chunked\r\n") + "5\r\nabcde\r\n0\r\n\r\n").status,
            422)
      << "within the limit, chunked is as good as any: this is merely no scene";
}

TEST_F(ServiceTest, AnUnreadBodyIsNoSecondRequest) {
  const std::string hidden = "GET /v1/info HTTP/1.1\r\nHost: localhost\r\n\r\n";
  Connection connection(port_);
  connection.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\nContent-Length: " + std::to_string(hidden.size()) +
                  "\r\n\r\n" + hidden);
  const std::string raw = connection.read_all();
  EXPECT_EQ(raw.find("max_upload_bytes"), std::string::npos);
  EXPECT_EQ(parse_reply(raw).status, 200);
  EXPECT_EQ(raw.find("HTTP/1.1", 1), std::string::npos) << "one answer only";
}

TEST_F(ServiceTest, RangesAreIgnored) {
  const std::string target = "/v1/openapi.json";
  const Reply whole = get(port_, target);
  for (const char* range :
       {"bytes=0-0", "bytes=5-,6-,7-,8-", "bytes=99999999-", "bytes=-5", "bytes=0-99999999"}) {
    const Reply reply = get(port_, target, {{"Range", range}});
    EXPECT_EQ(reply.status, 200) << range;
    EXPECT_EQ(reply.body, whole.body) << range;
  }
}

TEST_F(ServiceTest, TheWebClientIsServedAndNothingElse) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("photond_client_" + std::to_string(getpid()));
  fs::create_directories(folder / "dist" / "assets");
  std::ofstream(folder / "dist" / "index.html") << "<p>hello";
  std::ofstream(folder / "dist" / "assets" / "a.js") << "1";
  std::ofstream(folder / "secret") << "classified";
  ServiceOptions options;
  options.client_dir = (folder / "dist").string();
  start(options);
  const Reply page = get(port_, "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<p>hello");
  EXPECT_EQ(page.headers.at("cache-control"), "no-store");
  EXPECT_NE(page.headers.at("content-security-policy").find("default-src 'self'"), std::string::npos);
  EXPECT_EQ(get(port_, "/assets/a.js").headers.at("content-type"), "text/javascript; charset=utf-8");
  for (const char* path : {"/../secret", "/%2e%2e/secret", "/assets/..%2f..%2fsecret", "/assets//..//../secret",
                           "//etc/passwd", "/..%5csecret", "/assets/"}) {
    const Reply reply = get(port_, path);
    EXPECT_EQ(reply.status, 404) << path;
    EXPECT_EQ(reply.body.find("classified"), std::string::npos) << path;
  }
  fs::remove_all(folder);
  EXPECT_EQ(get(port_, "/").body, page.body) << "what was there at the start is kept in memory";
}

TEST_F(ServiceTest, AnOccupiedPortIsAClearError) {
  ServiceOptions options;
  options.port = port_;
  const TemporaryFolder other;
  options.data_dir = other.path().string();
  const auto second = Service::start(options);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::io);
  EXPECT_NE(second.error().message.find(std::to_string(port_)), std::string::npos);
  EXPECT_NE(second.error().message.find("in use"), std::string::npos) << second.error().message;
  EXPECT_EQ(get(port_, "/healthz").status, 200);
}

TEST_F(ServiceTest, TheUrlOfAnAddressOfIPv6HasBrackets) {
  ServiceOptions options;
  options.host = "::1";
  options.port = 0;
  options.data_dir = data_->file("other");
  const auto service = Service::start(options);
  if (!service.ok()) {
    EXPECT_EQ(service.error().message.find("cannot listen on [::1]:0: "), 0u) << service.error().message;
    GTEST_SKIP() << "this machine has no IPv6";
  }
  EXPECT_EQ((*service)->url(), "http://[::1]:" + std::to_string((*service)->port()) + "/");
}

TEST_F(ServiceTest, BadOptionsAreRefused) {
  ServiceOptions options;
  const TemporaryFolder data;
  options.data_dir = data.path().string();
  options.port = 70'000;
  EXPECT_FALSE(Service::start(options).ok());
  options.port = 0;
  options.client_dir = "/no/such/folder";
  EXPECT_FALSE(Service::start(options).ok());
  options.client_dir = "";
  options.samples_dir = "/no/such/folder";
  EXPECT_FALSE(Service::start(options).ok());
  options.samples_dir = "";
  options.max_job_memory_bytes = 0;
  EXPECT_FALSE(Service::start(options).ok());
  options.max_job_memory_bytes = 1;
  EXPECT_TRUE(Service::start(options).ok());
  options.data_dir = "";
  EXPECT_FALSE(Service::start(options).ok());
}

TEST_F(ServiceTest, TwoServicesDoNotShareADataDirectory) {
  ServiceOptions options;
  options.port = 0;
  options.data_dir = data_->file("data");
  const auto second = Service::start(options);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::conflict);
  EXPECT_NE(second.error().message.find("is used by another photond"), std::string::npos);
}

TEST_F(ServiceTest, ManyClientsAtOnceAreServed) {
  std::atomic<int> served = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 40; ++i) {
    clients.emplace_back([&] {
      for (int k = 0; k < 5; ++k) served += get(port_, "/v1/info").status == 200;
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(served, 200);
}

}  // namespace
}  // namespace photond::test
