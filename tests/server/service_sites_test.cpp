// Which pages of a browser are let in.
#include <set>

#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using nlohmann::json;

/// The headers of answers that the contract tells of.
std::set<std::string> announced_headers(const json& contract) {
  std::set<std::string> names;
  const auto collect = [&names](const json& answers) {
    for (const json& answer : answers) {
      const json headers = answer.value("headers", json::object());
      for (const auto& [name, header] : headers.items()) names.insert(name);
    }
  };
  for (const json& path : contract["paths"]) {
    for (const json& operation : path) collect(operation["responses"]);
  }
  collect(contract["components"]["responses"]);
  return names;
}

/// The status of a request with exactly these header lines.
int status_of(int port, const std::string& line, const std::string& fields) {
  Connection connection(port);
  connection.send(line + " HTTP/1.1\r\n" + fields + "\r\n");
  return parse_reply(connection.read_all()).status;
}

TEST_F(ServiceTest, WithoutKeysOnlyTheNamesOfThisMachineAreAnswered) {
  const auto ask = [this](const std::string& host) {
    return status_of(port_, "GET /v1/jobs", "Host: " + host + "\r\n");
  };
  for (const char* host : {"localhost", "LOCALHOST:8080", "localhost.", "x.localhost:1", "127.0.0.1", "127.0.0.1:8080",
                           "[::1]:8080", "192.168.0.7:8080", "[fe80::1]", ""}) {
    EXPECT_EQ(ask(host), 200) << host;
  }
  for (const char* host : {"evil.example:8080", "evil.example", "127.0.0.1.evil.example", "localhost.evil.example",
                           "1.2.3.x", "evillocalhost", "[evil]"}) {
    EXPECT_EQ(ask(host), 403) << "a name that somebody else has pointed here: " << host;
  }
  EXPECT_EQ(status_of(port_, "GET /v1/jobs", "Host: evil.example\r\nSec-Fetch-Site: same-origin\r\n"), 403);
  EXPECT_EQ(status_of(port_, "GET /healthz", "Host: evil.example\r\n"), 403);

  ServiceOptions options;
  options.cors_origins = {"https://photond.example.org:8443"};
  start(options);
  EXPECT_EQ(ask("photond.example.org"), 200) << "an allowed site's own name, as a proxy passes it on";
  EXPECT_EQ(ask("evil.example"), 403);
  options.insecure = true;
  start(options);
  EXPECT_EQ(ask("renderer.local"), 200) << "whoever reaches it may use it";
}

TEST_F(ServiceTest, OnlyItsOwnPageMayChangeAnything) {
  const auto post = [this](const std::string& fields) {
    return status_of(port_, "POST /v1/jobs/x/cancel", "Host: localhost:8080\r\n" + fields);
  };
  EXPECT_EQ(post(""), 404) << "no browser";
  EXPECT_EQ(post("Origin: http://localhost:8080\r\n"), 404);
  EXPECT_EQ(post("Origin: http://localhost:8080\r\nSec-Fetch-Site: same-origin\r\n"), 404);
  EXPECT_EQ(post("Sec-Fetch-Site: none\r\n"), 404);
  for (const char* fields : {"Origin: http://localhost:9090", "Origin: https://evil.example", "Origin: null",
                             "Origin: http://localhost", "Sec-Fetch-Site: same-site", "Sec-Fetch-Site: cross-site", "Sec-Fetch-Site: x",
                             "Origin: http://localhost:8080\r\nSec-Fetch-Site: same-site"}) {
    EXPECT_EQ(post(std::string(fields) + "\r\n"), 403) << fields;
  }
  EXPECT_EQ(status_of(port_, "POST /v1/jobs/x/cancel", "Host: localhost\r\nOrigin: https://localhost:8443\r\n"), 404)
      << "a proxy may pass the name on without its port";
  EXPECT_EQ(status_of(port_, "GET /v1/jobs", "Host: localhost:8080\r\nOrigin: https://evil.example\r\n"), 200)
      << "looking changes nothing, and that page sees nothing of it";
}

TEST_F(ServiceTest, OtherSitesAreNotLetInUnlessNamed) {
  const Fields asked{{"Origin", "https://example.org"}, {"Access-Control-Request-Method", "POST"}};
  EXPECT_EQ(request(port_, "OPTIONS", "/v1/jobs", "", "", asked).status, 403);
  EXPECT_EQ(get(port_, "/v1/jobs", asked).headers.count("access-control-allow-origin"), 0u);

  ServiceOptions options;
  options.cors_origins = {"https://example.org", "http://localhost:5173"};
  start(options);
  const Reply preflight = request(port_, "OPTIONS", "/v1/jobs", "", "", asked);
  EXPECT_EQ(preflight.status, 204);
  EXPECT_EQ(preflight.headers.at("access-control-allow-origin"), "https://example.org");
  EXPECT_EQ(preflight.headers.at("access-control-allow-methods"), "POST, GET, HEAD");
  EXPECT_NE(preflight.headers.at("access-control-allow-headers").find("Authorization"), std::string::npos);
  const Reply answer = get(port_, "/v1/jobs", asked);
  EXPECT_EQ(answer.headers.at("access-control-allow-origin"), "https://example.org");
  EXPECT_EQ(answer.headers.at("vary"), "Origin");
  EXPECT_NE(answer.headers.at("access-control-expose-headers").find("ETag"), std::string::npos);
  EXPECT_NE(preflight.headers.at("access-control-allow-headers").find("If-Range"), std::string::npos);
  const std::string exposed = answer.headers.at("access-control-expose-headers") + ", Cache-Control,";
  for (const std::string& name : announced_headers(json::parse(get(port_, "/v1/openapi.json").body))) {
    EXPECT_NE(exposed.find(name + ","), std::string::npos) << name;
  }
  const Fields cross{{"Origin", "https://example.org"}, {"Sec-Fetch-Site", "cross-site"}};
  EXPECT_EQ(request(port_, "POST", "/v1/jobs/x/cancel", "", "", cross).status, 404) << "let in, though from elsewhere";
  for (const char* origin : {"https://example.org.evil.net", "http://example.org", "https://example.org:444", "null"}) {
    const Fields other{{"Origin", origin}, {"Access-Control-Request-Method", "POST"}, {"Sec-Fetch-Site", "cross-site"}};
    EXPECT_EQ(request(port_, "OPTIONS", "/v1/jobs", "", "", other).headers.count("access-control-allow-origin"), 0u);
    EXPECT_EQ(request(port_, "POST", "/v1/jobs/x/cancel", "", "", other).status, 403) << origin;
  }
  for (const char* origin : {"*", "example.org", "https://example.org/", "https://a b"}) {
    options.cors_origins = {origin};
    options.port = 0;
    EXPECT_FALSE(Service::start(options).ok()) << origin;
  }
}

}  // namespace
}  // namespace photond::test
