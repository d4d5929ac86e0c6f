#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "core/base/result.h"
#include "server/http/head.h"
#include "server/http/socket.h"

namespace photond {

/// A request that has arrived: its head, and as much of its body as came along.
struct Arrival {
  Socket socket;
  std::variant<Head, BadHead> head;
  std::string body;
  std::string peer;  ///< address of the other end
};

/// What the process may open, less what it keeps back for files.
int spare_descriptor();

struct DoormanOptions {
  std::string host;
  int port = 0;
  std::size_t max_waiting = 2048;           ///< connections whose request has not arrived yet
  int max_descriptor = spare_descriptor();  ///< connections leave the descriptors from here on to files
  std::size_t whole_body_bytes = 64 * 1024; ///< bodies up to this length arrive before the request is let in
  std::chrono::milliseconds patience{10'000};  ///< for the whole head, and again for such a body
};

/// Accepts connections and keeps them, all on one thread, until their request has arrived, so that a client that
/// dawdles costs a descriptor and some kilobytes, never a thread. Sees clients out the same way: a connection
/// closed on bytes that nobody read would be reset before the client has read its answer.
class Doorman {
 public:
  enum class Loss { slow, crowded, descriptors, exception };  ///< why a connection was dropped unanswered

  /// What they throw, for want of memory, costs one connection.
  struct Calls {
    /// Takes an arrival; false where nobody is free, then the client hears 503.
    std::function<bool(Arrival&&)> enter;
    std::function<void(Loss)> lost;
  };

  /// Listens. Errors: io.
  static Result<std::unique_ptr<Doorman>> open(const DoormanOptions& options);
  ~Doorman();

  int port() const;
  /// Begins to accept.
  void begin(Calls calls);
  /// Ends a connection politely: says that nothing follows, reads and drops what still comes for a while.
  void see_out(Socket socket);
  /// Accepts nothing any more and drops everybody who waits. Whoever has entered is not concerned.
  void close();

 private:
  class Hall;
  explicit Doorman(std::unique_ptr<Hall> hall);
  std::unique_ptr<Hall> hall_;
};

}  // namespace photond
