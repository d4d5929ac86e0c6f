#include "server/http/doorman.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

namespace photond {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTick{250};      // how exactly patience is measured
constexpr std::chrono::seconds kLeaveSeconds{5};     // for a client to read its answer and close
constexpr std::uint64_t kMaxDropped = 64 << 20;      // bytes read and dropped meanwhile
constexpr std::size_t kReadBytes = 64 * 1024;
constexpr rlim_t kFileDescriptors = 192;             // the service's own files, and one for each answer from the disk

/// An answer without a thread that could make one. It must fit into the buffer of a fresh socket, and does.
void tell(const Socket& socket, std::string_view status, std::string_view body) {
  std::string text("HTTP/1.1 ");
  text.append(status).append("\r\nContent-Type: application/problem+json\r\nRetry-After: 2\r\nCache-Control: no-store\r\n");
  text.append("Connection: close\r\nContent-Length: ").append(std::to_string(body.size())).append("\r\n\r\n").append(body);
  ::send(socket.fd(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
}

void tell_busy(const Socket& socket) {
  tell(socket, "503 Service Unavailable",
       R"({"type":"about:blank","title":"Unavailable","status":503,"code":"too_many_threads",)"
       R"("detail":"too many requests at once"})");
}

void tell_late(const Socket& socket) {
  tell(socket, "408 Request Timeout",
       R"({"type":"about:blank","title":"Request timeout","status":408,"code":"too_slow",)"
       R"("detail":"the request took too long to arrive"})");
}

/// The same connection by the lowest descriptor that is free; nobody listens to it by the other one yet.
Socket moved_down(Socket& socket) {
  const int lowest = ::fcntl(socket.fd(), F_DUPFD_CLOEXEC, 0);
  return lowest >= 0 ? Socket(lowest) : std::move(socket);
}

std::string address_text(const sockaddr_storage& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const void* bytes = address.ss_family == AF_INET6
                          ? static_cast<const void*>(&reinterpret_cast<const sockaddr_in6&>(address).sin6_addr)
                          : static_cast<const void*>(&reinterpret_cast<const sockaddr_in&>(address).sin_addr);
  ::inet_ntop(address.ss_family, bytes, text.data(), text.size());
  return text.data();
}

}  // namespace

int spare_descriptor() {
  rlimit files{};
  ::getrlimit(RLIMIT_NOFILE, &files);
  const rlim_t most = std::min<rlim_t>(files.rlim_cur, std::numeric_limits<int>::max());
  return static_cast<int>(most - std::min(kFileDescriptors, most / 2));
}

/// Where those wait who have not entered, and those who leave.
class Doorman::Hall {
 public:
  Hall(const DoormanOptions& options, Socket listening)
      : options_(options), listening_(std::move(listening)), port_(listening_.port()),
        epoll_(::epoll_create1(EPOLL_CLOEXEC)), wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    watch(listening_.fd());
    watch(wake_.fd());
  }

  int port() const { return port_; }
  void begin(Calls calls);
  void take_leaving(Socket socket);
  void close();

 private:
  struct Visitor {
    Socket socket;
    std::string peer;
    std::string received;            ///< of a head, then of its body
    std::variant<Head, BadHead> head;
    bool has_head = false;           ///< the head is whole: its body is still to come
    bool leaves = false;             ///< answered: what still comes is dropped
    std::uint64_t dropped = 0;
    SteadyTime deadline;
  };

  void run();
  void handle(int fd);
  template <class Act>
  void attend(int fd, const Act& act);
  void give_up(int fd);
  void wake() const;
  void watch(int fd) const;
  void accept_all();
  void welcome(Socket socket, std::string peer);
  void make_room();
  void add_leaving();
  void add(Visitor visitor);
  void hear(Visitor& visitor);
  void drop_bytes(Visitor& visitor, std::size_t bytes);
  void advance(Visitor& visitor);
  void let_in(Visitor& visitor);
  void remove(int fd);
  void remove_late();
  void show_out(const Visitor& visitor);

  const DoormanOptions options_;
  Calls calls_;
  Socket listening_;
  const int port_;
  Socket epoll_, wake_;  // descriptors that are no sockets, but close alike
  std::unordered_map<int, Visitor> visitors_;
  bool accepting_ = true;
  std::vector<char> buffer_ = std::vector<char>(kReadBytes);

  std::mutex mutex_;
  std::vector<Socket> leaving_;  ///< handed over by other threads
  std::atomic<bool> closing_{false};
  std::thread thread_;
};

void Doorman::Hall::wake() const {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t n = ::write(wake_.fd(), &one, sizeof one);
}

void Doorman::Hall::watch(int fd) const {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = fd;
  ::epoll_ctl(epoll_.fd(), EPOLL_CTL_ADD, fd, &event);
}

void Doorman::Hall::take_leaving(Socket socket) {
  if (closing_) return;
  try {
    const std::lock_guard lock(mutex_);
    leaving_.push_back(std::move(socket));
  } catch (const std::exception&) {  // no memory for politeness
    return;
  }
  wake();
}

void Doorman::Hall::begin(Calls calls) {
  calls_ = std::move(calls);
  thread_ = std::thread([this] { run(); });
}

void Doorman::Hall::close() {
  closing_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

void Doorman::Hall::run() {
  SteadyTime next_look = Clock::now() + kTick;
  while (!closing_) {
    std::array<epoll_event, 256> events{};
    const int count = ::epoll_wait(epoll_.fd(), events.data(), events.size(), static_cast<int>(kTick.count()));
    for (int i = 0; i < count; ++i) {
      const int fd = events[static_cast<std::size_t>(i)].data.fd;
      attend(fd, [this, fd] { handle(fd); });
    }
    if (Clock::now() < next_look) continue;
    next_look = Clock::now() + kTick;
    remove_late();
  }
  listening_ = Socket();
  visitors_.clear();
}

/// Looks what has happened at a descriptor.
void Doorman::Hall::handle(int fd) {
  if (fd == listening_.fd()) {
    accept_all();
  } else if (fd == wake_.fd()) {
    add_leaving();
  } else if (const auto found = visitors_.find(fd); found != visitors_.end()) {
    hear(found->second);
  }
}

/// Acts for the visitor of a descriptor. What is thrown, for want of memory, costs that visitor and nobody else.
template <class Act>
void Doorman::Hall::attend(int fd, const Act& act) {
  try {
    act();
  } catch (const std::exception&) {
    give_up(fd);
  }
}

void Doorman::Hall::give_up(int fd) {
  remove(fd);
  try {
    calls_.lost(Loss::exception);
  } catch (const std::exception&) {  // nor is there memory to count it
  }
}

void Doorman::Hall::accept_all() {
  while (true) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    Socket socket(::accept4(listening_.fd(), reinterpret_cast<sockaddr*>(&address), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.fd() >= 0) {
      const int yes = 1;
      ::setsockopt(socket.fd(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      attend(socket.fd(), [&] { welcome(std::move(socket), address_text(address)); });
    } else if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
      calls_.lost(Loss::descriptors);
      if (!visitors_.empty()) {
        make_room();
        continue;
      }
      // The listener stays readable: without a pause this thread would spin.
      ::epoll_ctl(epoll_.fd(), EPOLL_CTL_DEL, listening_.fd(), nullptr);
      accepting_ = false;
      return;
    } else if (errno != EINTR && errno != ECONNABORTED) {
      return;
    }
  }
}

void Doorman::Hall::welcome(Socket socket, std::string peer) {
  // A new descriptor is the lowest that is free: all below it are taken.
  const bool scarce = socket.fd() >= options_.max_descriptor;
  if (scarce && visitors_.empty()) {
    calls_.lost(Loss::descriptors);
    return tell_busy(socket);
  }
  if (scarce || visitors_.size() >= options_.max_waiting) make_room();
  if (scarce) socket = moved_down(socket);
  Visitor visitor;
  visitor.socket = std::move(socket);
  visitor.peer = std::move(peer);
  visitor.deadline = Clock::now() + options_.patience;
  add(std::move(visitor));
}

void Doorman::Hall::add(Visitor visitor) {
  const int fd = visitor.socket.fd();
  watch(fd);
  // Most requests have arrived whole by now.
  hear(visitors_.insert_or_assign(fd, std::move(visitor)).first->second);
}

/// Drops who has waited longest: honest requests take milliseconds to arrive.
void Doorman::Hall::make_room() {
  auto oldest = visitors_.begin();
  for (auto at = visitors_.begin(); at != visitors_.end(); ++at) {
    if (at->second.deadline < oldest->second.deadline) oldest = at;
  }
  if (!oldest->second.leaves) calls_.lost(Loss::crowded);
  remove(oldest->first);
}

void Doorman::Hall::add_leaving() {
  std::uint64_t count = 0;
  [[maybe_unused]] const ssize_t n = ::read(wake_.fd(), &count, sizeof count);
  std::vector<Socket> leaving;
  {
    const std::lock_guard lock(mutex_);
    leaving.swap(leaving_);
  }
  for (Socket& socket : leaving) {
    ::shutdown(socket.fd(), SHUT_WR);
    const int fd = socket.fd();
    Visitor visitor;
    visitor.socket = std::move(socket);
    visitor.leaves = true;
    visitor.deadline = Clock::now() + kLeaveSeconds;
    attend(fd, [&] { add(std::move(visitor)); });
  }
}

void Doorman::Hall::hear(Visitor& visitor) {
  const ssize_t n = ::recv(visitor.socket.fd(), buffer_.data(), buffer_.size(), 0);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (n <= 0) return remove(visitor.socket.fd());
  if (visitor.leaves) return drop_bytes(visitor, static_cast<std::size_t>(n));
  visitor.received.append(buffer_.data(), static_cast<std::size_t>(n));
  advance(visitor);
}

void Doorman::Hall::drop_bytes(Visitor& visitor, std::size_t bytes) {
  visitor.dropped += bytes;
  if (visitor.dropped > kMaxDropped) remove(visitor.socket.fd());
}

/// Looks whether the request has arrived.
void Doorman::Hall::advance(Visitor& visitor) {
  if (!visitor.has_head) {
    const std::size_t end = visitor.received.find("\r\n\r\n");
    const std::size_t size = end == std::string::npos ? visitor.received.size() : end + 4;
    if (size > kMaxHeadBytes) {
      visitor.head = BadHead{431, "the header lines are too long"};
      return let_in(visitor);
    }
    if (end == std::string::npos) return;
    visitor.head = parse_head(std::string_view(visitor.received).substr(0, size));
    visitor.has_head = true;
    visitor.received.erase(0, size);
    visitor.deadline = Clock::now() + options_.patience;
  }
  const Head* head = std::get_if<Head>(&visitor.head);
  const std::uint64_t awaited = head != nullptr && !head->expects_continue ? head->length.value_or(0) : 0;
  if (awaited <= options_.whole_body_bytes && visitor.received.size() < awaited) return;
  let_in(visitor);
}

void Doorman::Hall::let_in(Visitor& visitor) {
  Arrival arrival{std::move(visitor.socket), std::move(visitor.head), std::move(visitor.received), std::move(visitor.peer)};
  const int fd = arrival.socket.fd();
  ::epoll_ctl(epoll_.fd(), EPOLL_CTL_DEL, fd, nullptr);
  visitors_.erase(fd);
  if (calls_.enter(std::move(arrival)) || arrival.socket.fd() < 0) return;  // else it was not moved from
  tell_busy(arrival.socket);
  take_leaving(std::move(arrival.socket));
}

void Doorman::Hall::remove(int fd) { visitors_.erase(fd); }  // closing takes it out of epoll too

void Doorman::Hall::remove_late() {
  const SteadyTime now = Clock::now();
  for (auto at = visitors_.begin(); at != visitors_.end();) {
    const int fd = at->first;
    const Visitor& visitor = (at++)->second;
    if (visitor.deadline > now) continue;
    if (!visitor.leaves) attend(fd, [&] { show_out(visitor); });
    remove(fd);
  }
  if (accepting_) return;
  accepting_ = true;
  watch(listening_.fd());
}

void Doorman::Hall::show_out(const Visitor& visitor) {
  calls_.lost(Loss::slow);
  if (visitor.has_head || !visitor.received.empty()) tell_late(visitor.socket);
}

Result<std::unique_ptr<Doorman>> Doorman::open(const DoormanOptions& options) {
  Result<Socket> listening = Socket::listen(options.host, options.port);
  if (!listening) return listening.error();
  return std::unique_ptr<Doorman>(new Doorman(std::make_unique<Hall>(options, std::move(*listening))));
}

Doorman::Doorman(std::unique_ptr<Hall> hall) : hall_(std::move(hall)) {}
Doorman::~Doorman() { close(); }

int Doorman::port() const { return hall_->port(); }
void Doorman::begin(Calls calls) { hall_->begin(std::move(calls)); }
void Doorman::see_out(Socket socket) { hall_->take_leaving(std::move(socket)); }
void Doorman::close() { hall_->close(); }

}  // namespace photond
