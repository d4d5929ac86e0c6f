#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/api/message.h"
#include "server/store/keys.h"

namespace photond {

struct Operation;

/// Finds out by the Authorization header who asks, into `request.caller`, and refuses: 401 where the operation needs a
/// key and none that is known was sent, 403 where the key may not do this. Where no keys are required everybody may do
/// everything.
std::optional<Response> authorize(const Keyring& keys, const Operation& operation, Request& request);

/// Counts the streams and long polls that are open by key. Thread-safe.
class OpenStreams {
 public:
  /// A place among those of the caller, given back when the last copy goes; null where all are taken.
  std::shared_ptr<void> take(const Caller& caller);

 private:
  struct Counts {
    std::mutex mutex;
    std::map<std::string, std::uint64_t> open;  ///< by key
  };
  std::shared_ptr<Counts> counts_ = std::make_shared<Counts>();
};

}  // namespace photond
