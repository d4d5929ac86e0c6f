#include "tests/server/http_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>

#include "tests/server/contract_check.h"

namespace photond::test {

namespace {

using Clock = std::chrono::steady_clock;

std::string unchunked(const std::string& coded) {
  std::string body;
  std::size_t at = 0;
  while (at < coded.size()) {
    const std::size_t size = std::stoul(coded.substr(at), nullptr, 16);
    at = coded.find("\r\n", at);
    if (size == 0 || at == std::string::npos) break;
    body += coded.substr(at + 2, size);
    at += 2 + size + 2;
  }
  return body;
}

}  // namespace

Connection::Connection(int port, bool narrow) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
  if (narrow) {
    const int least = 1;        // the system takes its own least
    const int segment = 536;    // the peer's buffer grows by segments
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &least, sizeof least);
    ::setsockopt(socket_, IPPROTO_TCP, TCP_MAXSEG, &segment, sizeof segment);
  }
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return;
  ::close(socket_);
  socket_ = -1;
}

Connection::~Connection() {
  if (socket_ >= 0) ::close(socket_);
}

bool Connection::send(const std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

const std::string& Connection::read_until(const std::string& end, std::chrono::milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  while (!closed_ && (end.empty() || received_.find(end) == std::string::npos)) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd ready{socket_, POLLIN, 0};
    if (left <= 0 || ::poll(&ready, 1, static_cast<int>(left)) <= 0) break;
    char buffer[65536];
    const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
    if (n > 0) received_.append(buffer, static_cast<std::size_t>(n));
    closed_ = n <= 0;
  }
  return received_;
}

const std::string& Connection::read_all(std::chrono::milliseconds timeout) { return read_until("", timeout); }

Reply parse_reply(const std::string& raw) {
  Reply reply;
  const std::size_t end = raw.find("\r\n\r\n");
  if (end == std::string::npos || raw.size() < 12) return reply;
  reply.status = std::stoi(raw.substr(9, 3));
  std::size_t at = raw.find("\r\n") + 2;
  while (at < end + 2) {
    const std::size_t line_end = raw.find("\r\n", at);
    const std::string line = raw.substr(at, line_end - at);
    const std::size_t colon = line.find(':');
    std::string name = line.substr(0, colon);
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    reply.headers[name] = line.substr(std::min(line.size(), colon + 2));
    at = line_end + 2;
  }
  reply.body = raw.substr(end + 4);
  if (reply.headers["transfer-encoding"] == "chunked") reply.body = unchunked(reply.body);
  return reply;
}

Reply request(int port, const std::string& method, const std::string& target, const std::string& body,
              const std::string& content_type, const Fields& fields) {
  std::string head = method + " " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\n";
  for (const auto& [name, value] : fields) head += name + ": " + value + "\r\n";
  if (!content_type.empty()) head += "Content-Type: " + content_type + "\r\n";
  if (!body.empty()) head += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  Connection connection(port);
  if (!connection.connected()) return {};
  connection.send(head + "\r\n" + body);
  Reply reply = parse_reply(connection.read_all());
  expect_contract_kept(method, target, reply);
  return reply;
}

Reply get(int port, const std::string& target, const Fields& fields) {
  return request(port, "GET", target, {}, {}, fields);
}

Reply post_json(int port, const std::string& target, const std::string& json) {
  return request(port, "POST", target, json, "application/json");
}

std::string chunked_body(std::size_t count, std::size_t size) {
  char head[32];
  std::snprintf(head, sizeof head, "%zx\r\n", size);
  std::string body;
  for (std::size_t i = 0; i < count; ++i) body += head + std::string(size, 'x') + "\r\n";
  return body + "0\r\n\r\n";
}

}  // namespace photond::test
