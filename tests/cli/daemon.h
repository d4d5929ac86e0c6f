#pragma once

#include <sys/types.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/server/http_client.h"
#include "tests/support/temporary_folder.h"

namespace photond::test {

/// A photond of the test's own on a data directory.
class Daemon {
 public:
  explicit Daemon(std::string data) : data_(std::move(data)) {}
  ~Daemon();

  /// With further arguments. Returns once it answers; false where it does not start.
  bool start(const std::vector<std::string>& arguments = {});
  void send(int signal) const;
  /// From now on it gets little more memory from the system, and no more threads.
  void limit_memory() const;
  /// Ends it by a signal; returns what waitpid says.
  int end(int signal);
  /// What it has written to stderr since the last start.
  std::string said() const;

  std::atomic<int> port{0};

 private:
  const std::string data_;
  const TemporaryFolder folder_;
  int starts_ = 0;
  pid_t pid_ = -1;
};

/// One request; status 0 where no whole answer came.
Reply ask(int port, const std::string& method, const std::string& target, const std::string& body = {},
          const std::string& type = "application/json");

/// The body of an answer; discarded where it is no JSON.
nlohmann::json parsed(const Reply& reply);

}  // namespace photond::test
