#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace photond::test {

/// What came back; header names in lower case.
struct Reply {
  int status = 0;  ///< 0: no answer
  std::map<std::string, std::string> headers;
  std::string body;
};

/// A TCP connection to 127.0.0.1 that sends exactly the bytes it is given.
class Connection {
 public:
  /// With `narrow`, the system holds some 40 kB between the two ends at most: what is not read soon stops the peer.
  explicit Connection(int port, bool narrow = false);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  bool connected() const { return socket_ >= 0; }
  /// False where the peer has closed.
  bool send(const std::string& bytes);
  /// Everything until `end` was seen in what arrived so far, the peer closed or the time is up.
  const std::string& read_until(const std::string& end, std::chrono::milliseconds timeout);
  /// Everything until the peer closes.
  const std::string& read_all(std::chrono::milliseconds timeout = std::chrono::seconds(30));
  bool closed() const { return closed_; }

 private:
  int socket_ = -1;
  bool closed_ = false;
  std::string received_;
};

using Fields = std::vector<std::pair<std::string, std::string>>;

/// One request on a connection of its own. Expects what comes back to be as the contract says.
Reply request(int port, const std::string& method, const std::string& target, const std::string& body = {},
              const std::string& content_type = {}, const Fields& fields = {});
Reply get(int port, const std::string& target, const Fields& fields = {});
/// Posts JSON.
Reply post_json(int port, const std::string& target, const std::string& json);

/// Splits a raw answer; undoes the chunked coding.
Reply parse_reply(const std::string& raw);

/// `count` chunks of `size` bytes in the chunked coding, with the end.
std::string chunked_body(std::size_t count, std::size_t size);

}  // namespace photond::test
