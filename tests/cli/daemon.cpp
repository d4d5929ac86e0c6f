#include "tests/cli/daemon.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "tests/cli/program.h"

namespace photond::test {

using namespace std::chrono_literals;

Daemon::~Daemon() { end(SIGKILL); }

bool Daemon::start(const std::vector<std::string>& arguments) {
  const std::string out = folder_.file("out" + std::to_string(++starts_));
  std::vector<std::string> all{"serve", "--port", "0", "--threads", "2", "--data", data_, "--log-level", "warning"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  pid_ = spawn_photond(all, out, folder_.file("err"));
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  while (std::chrono::steady_clock::now() < deadline) {
    const std::string said = read_text(out);
    if (const std::size_t at = said.find("http://127.0.0.1:"); at != std::string::npos && said.find('\n') != std::string::npos) {
      port = std::stoi(said.substr(at + 17));
      return true;
    }
    if (::waitpid(pid_, nullptr, WNOHANG) != 0) break;
    std::this_thread::sleep_for(5ms);
  }
  ADD_FAILURE() << "photond does not start: " << said();
  return false;
}

void Daemon::send(int signal) const { ::kill(pid_, signal); }

void Daemon::limit_memory() const {
  constexpr rlim_t kLeft = 1 << 20;  // less than a stack
  const rlim_t pages = std::stoull(read_text("/proc/" + std::to_string(pid_) + "/statm"));
  const rlimit most{pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + kLeft, RLIM_INFINITY};
  ASSERT_EQ(::prlimit(pid_, RLIMIT_AS, &most, nullptr), 0);
}

int Daemon::end(int signal) {
  if (pid_ <= 0) return 0;
  port = 0;
  ::kill(pid_, signal);
  int status = 0;
  ::waitpid(pid_, &status, 0);
  pid_ = -1;
  return status;
}

std::string Daemon::said() const { return read_text(folder_.path() / "err"); }

Reply ask(int port, const std::string& method, const std::string& target, const std::string& body,
          const std::string& type) {
  if (port == 0) return {};
  Connection connection(port);
  if (!connection.connected()) return {};
  std::string head = method + " " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\n";
  if (!body.empty()) head += "Content-Type: " + type + "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
  connection.send(head + "\r\n" + body);
  Reply reply = parse_reply(connection.read_all());
  const auto length = reply.headers.find("content-length");
  const bool whole = length == reply.headers.end() || length->second == std::to_string(reply.body.size());
  return whole ? reply : Reply{};
}

nlohmann::json parsed(const Reply& reply) { return nlohmann::json::parse(reply.body, nullptr, false); }

}  // namespace photond::test
