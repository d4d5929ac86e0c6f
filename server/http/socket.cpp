#include "server/http/socket.h"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

namespace photond {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{250};      // how soon a stop is noticed
constexpr std::chrono::seconds kLastWrites{5};       // what a stop leaves to answers on their way
constexpr int kBacklog = 4096;                       // bursts; the kernel cuts it to net.core.somaxconn

/// Waits until `events` can be had or the time is up.
bool wait_for(int fd, short events, SteadyTime deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
  pollfd ready{fd, events, 0};
  const int count = ::poll(&ready, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
  return count > 0;
}

Error cannot_listen(const std::string& host, int port, const std::string& reason) {
  return {ErrorCode::io, "cannot listen on " + host_and_port(host, port) + ": " + reason, ""};
}

}  // namespace

std::string host_and_port(const std::string& host, int port) {
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return (is_ipv6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

Socket::~Socket() {
  if (fd_ >= 0) ::close(fd_);
}

Result<Socket> Socket::listen(const std::string& host, int port) {
  addrinfo wish{};
  wish.ai_socktype = SOCK_STREAM;
  wish.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* list = nullptr;
  if (const int failed = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wish, &list); failed != 0) {
    return cannot_listen(host, port, ::gai_strerror(failed));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(list, ::freeaddrinfo);
  int reason = 0;
  for (const addrinfo* at = list; at != nullptr; at = at->ai_next) {
    Socket socket(::socket(at->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const int yes = 1;
    // A port in TIME_WAIT may be taken again; one that another service listens on may not.
    ::setsockopt(socket.fd(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (::bind(socket.fd(), at->ai_addr, at->ai_addrlen) == 0 && ::listen(socket.fd(), kBacklog) == 0) return socket;
    reason = errno;
  }
  return cannot_listen(host, port, std::strerror(reason));
}

int Socket::port() const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
  const auto* v4 = reinterpret_cast<const sockaddr_in*>(&address);
  const auto* v6 = reinterpret_cast<const sockaddr_in6*>(&address);
  return ntohs(address.ss_family == AF_INET6 ? v6->sin6_port : v4->sin_port);
}

long Socket::read(char* to, std::size_t size, SteadyTime deadline, const std::stop_token& stop) {
  while (true) {
    const ssize_t n = ::recv(fd_, to, size, 0);
    if (n >= 0) return n;
    if (errno == EINTR) continue;
    if (errno != EAGAIN || stop.stop_requested() || Clock::now() >= deadline) return -1;
    wait_for(fd_, POLLIN, std::min(deadline, Clock::now() + kLook));
  }
}

bool Socket::write(const char* from, std::size_t size, SteadyTime deadline, const std::stop_token& stop) {
  bool stopping = false;
  while (size > 0) {
    const ssize_t n = ::send(fd_, from, size, MSG_NOSIGNAL);
    if (n > 0) {
      from += n;
      size -= static_cast<std::size_t>(n);
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN) return false;
    if (!stopping && stop.stop_requested()) {
      stopping = true;
      deadline = std::min(deadline, Clock::now() + kLastWrites);
    }
    if (Clock::now() >= deadline) return false;
    wait_for(fd_, POLLOUT, std::min(deadline, Clock::now() + kLook));
  }
  return true;
}

bool Socket::peer_gone() const {
  pollfd state{fd_, POLLRDHUP, 0};
  return ::poll(&state, 1, 0) > 0;
}

}  // namespace photond
