#include "tests/server/service_fixture.h"

namespace photond::test {
namespace {

using namespace std::chrono_literals;

struct Part {
  std::string type;
  std::string body;
};

/// The parts of a whole multipart body, which must end as one does.
std::vector<Part> parse_parts(const Reply& reply) {
  const std::string type = reply.headers.at("content-type");
  const std::string boundary = "--" + type.substr(type.find("boundary=") + 9);
  std::vector<Part> parts;
  std::size_t at = 0;
  while (reply.body.compare(at, boundary.size() + 2, boundary + "\r\n") == 0) {
    const std::size_t body = reply.body.find("\r\n\r\n", at) + 4;
    const Reply head = parse_reply("HTTP/1.1 200 OK" + reply.body.substr(at + boundary.size(), body - at - boundary.size()));
    const std::size_t size = std::stoul(head.headers.at("content-length"));
    parts.push_back({head.headers.at("content-type"), reply.body.substr(body, size)});
    EXPECT_EQ(reply.body.substr(body + size, 2), "\r\n");
    at = body + size + 2;
  }
  EXPECT_EQ(reply.body.substr(at), boundary + "--\r\n");
  return parts;
}

TEST_F(ServiceTest, ThePictureStreamSendsEveryPictureTwiceAndEndsWithItsJob) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"seconds":2})");
  const Reply reply = get(port_, "/v1/jobs/" + id + "/stream.mjpg");
  EXPECT_EQ(reply.status, 200);
  EXPECT_TRUE(reply.headers.at("content-type").starts_with("multipart/x-mixed-replace; boundary="));
  EXPECT_EQ(reply.headers.at("x-accel-buffering"), "no");
  const std::vector<Part> parts = parse_parts(reply);
  ASSERT_GE(parts.size(), 4u) << "a first picture, and the result";
  ASSERT_EQ(parts.size() % 2, 0u);
  for (std::size_t i = 0; i < parts.size(); i += 2) {
    EXPECT_EQ(parts[i].type, "image/jpeg");
    EXPECT_TRUE(parts[i].body.starts_with("\xff\xd8\xff")) << "a JPEG";
    EXPECT_EQ(parts[i].body, parts[i + 1].body) << i;
  }
  EXPECT_EQ(parts.back().body, get(port_, "/v1/jobs/" + id + "/frames/latest.jpg").body) << "ends with the result";
  const std::vector<Part> later = parse_parts(get(port_, "/v1/jobs/" + id + "/stream.mjpg"));
  ASSERT_EQ(later.size(), 2u) << "of a job that has ended only the result";
  EXPECT_EQ(later[0].body, parts.back().body);
  EXPECT_EQ(get(port_, "/v1/jobs/none/stream.mjpg").status, 404);
}

TEST_F(ServiceTest, AViewerThatGoesEndsNoJob) {
  const std::string id = submit(upload(), R"("method":"path","stop":{"seconds":2})");
  {
    Connection viewer(port_);
    viewer.send("GET /v1/jobs/" + id + "/stream.mjpg HTTP/1.1\r\nHost: localhost\r\n\r\n");
    viewer.read_until("image/jpeg", 10s);
  }
  EXPECT_EQ(wait_for_end(id)["state"], "succeeded");
}

}  // namespace
}  // namespace photond::test
