#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "server/service.h"
#include "tests/server/http_client.h"
#include "tests/server/small_scene.h"
#include "tests/support/temporary_folder.h"

namespace photond::test {

/// A service on a port of its own, and the requests most tests make.
class ServiceTest : public ::testing::Test {
 protected:
  void SetUp() override { start({}); }

  /// Replaces the service by one with other options and nothing known.
  void start(ServiceOptions options) {
    service_.reset();
    data_ = std::make_unique<TemporaryFolder>();
    restart(std::move(options));
  }

  /// Replaces the service by one that finds what the one before has left.
  void restart(ServiceOptions options = {}) {
    service_.reset();
    options.port = 0;
    options.threads = 2;
    if (options.data_dir.empty()) options.data_dir = data_->file("data");
    auto service = Service::start(options);
    ASSERT_TRUE(service.ok()) << service.error().message;
    service_ = std::move(*service);
    port_ = service_->port();
  }

  /// Uploads and returns the id.
  std::string upload(const std::string& glb = small_glb()) {
    const Reply reply = request(port_, "POST", "/v1/scenes", glb, "model/gltf-binary");
    EXPECT_TRUE(reply.status == 201 || reply.status == 200) << reply.status << " " << reply.body;
    return nlohmann::json::parse(reply.body, nullptr, false).value("id", "");
  }

  /// Submits a job with `fields` beside the scene; a small film unless they say otherwise.
  std::string submit(const std::string& scene, const std::string& fields) {
    const std::string film =
        fields.find("\"film\"") == std::string::npos ? R"("film":{"width":16,"height":12},)" : "";
    const Reply reply = post_json(port_, "/v1/jobs", "{\"scene\":\"" + scene + "\"," + film + fields + "}");
    EXPECT_EQ(reply.status, 202) << reply.body;
    return nlohmann::json::parse(reply.body, nullptr, false).value("id", "");
  }

  nlohmann::json job(const std::string& id) {
    return nlohmann::json::parse(get(port_, "/v1/jobs/" + id).body, nullptr, false);
  }

  /// The job once it has this state; fails after a minute.
  nlohmann::json wait_for_state(const std::string& id, const std::string& state) {
    nlohmann::json now;
    for (int i = 0; i < 3000; ++i) {
      now = job(id);
      if (now.value("state", "") == state) return now;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    ADD_FAILURE() << "the job does not become " << state << ": " << now;
    return now;
  }

  /// The job once it has ended; fails after a minute.
  nlohmann::json wait_for_end(const std::string& id) {
    std::string etag = "\"none\"";
    nlohmann::json now;
    for (int i = 0; i < 600; ++i) {
      const Reply reply = get(port_, "/v1/jobs/" + id + "?wait=10", {{"If-None-Match", etag}});
      if (reply.status == 304) continue;
      now = nlohmann::json::parse(reply.body, nullptr, false);
      const std::string state = now.value("state", "");
      if (reply.status != 200 || state == "succeeded" || state == "failed" || state == "canceled") return now;
      etag = reply.headers.at("etag");
    }
    ADD_FAILURE() << "the job does not end";
    return now;
  }

  /// By how many bytes the process grows with so many readers of a body of x's who stop after its beginning.
  std::int64_t memory_of_slow_readers(const std::string& target, std::size_t count) {
    const auto memory = [this] {
      const std::string text = get(port_, "/metrics").body, name = "\nprocess_resident_memory_bytes ";
      return std::stoll(text.substr(text.find(name) + name.size()));
    };
    const auto before = memory();
    std::vector<std::unique_ptr<Connection>> readers;
    for (std::size_t i = 0; i < count; ++i) {
      readers.push_back(std::make_unique<Connection>(port_, true));
      readers.back()->send("GET " + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
      const std::string begun = readers.back()->read_until("\r\n\r\nxxx", std::chrono::seconds(10));
      EXPECT_TRUE(begun.starts_with("HTTP/1.1 200")) << begun;
    }
    return memory() - before;
  }

  std::unique_ptr<TemporaryFolder> data_;
  std::unique_ptr<Service> service_;
  int port_ = 0;
};

}  // namespace photond::test
