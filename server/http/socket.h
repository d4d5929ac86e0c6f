#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <utility>

#include "core/base/result.h"

namespace photond {

using SteadyTime = std::chrono::steady_clock::time_point;

/// How long a transfer may take: a time of grace, and then no slower than a rate, with no pause longer than the grace.
/// Limits the whole transfer, not every read: a client that sends a byte now and then does not get more time by it.
class Pace {
 public:
  static constexpr std::chrono::seconds kGrace{15};
  static constexpr std::uint64_t kBytesPerSecond = 64 * 1024;

  void moved(std::size_t bytes) { bytes_ += bytes; }
  /// When the transfer has failed unless it has moved on by then.
  SteadyTime deadline() const {
    return std::min(begin_ + std::chrono::seconds(bytes_ / kBytesPerSecond), std::chrono::steady_clock::now()) + kGrace;
  }

 private:
  SteadyTime begin_ = std::chrono::steady_clock::now();
  std::uint64_t bytes_ = 0;
};

/// `host:port` as URLs have it: an address of IPv6 in brackets.
std::string host_and_port(const std::string& host, int port);

/// A TCP socket that does not block, closed with the object.
class Socket {
 public:
  Socket() = default;
  explicit Socket(int fd) : fd_(fd) {}
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Socket();

  /// Binds and listens. `port` 0 takes any free one. Never shares a port with another process. Errors: io.
  static Result<Socket> listen(const std::string& host, int port);
  /// The port it is bound to.
  int port() const;

  int fd() const { return fd_; }
  /// Waits for bytes and reads some: their number, 0 at the end, -1 on an error, after `deadline` or a stop.
  long read(char* to, std::size_t size, SteadyTime deadline, const std::stop_token& stop);
  /// Writes all; false on an error, after `deadline`, or some seconds after a stop.
  bool write(const char* from, std::size_t size, SteadyTime deadline, const std::stop_token& stop);
  /// Whether the other end has closed or gone.
  bool peer_gone() const;

 private:
  int fd_ = -1;
};

}  // namespace photond
