#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>

#include "server/http/head.h"
#include "server/http/socket.h"

namespace photond {

enum class BodyEnd {
  complete,
  too_large,  ///< more than the limit, as stated or as counted
  malformed,  ///< the chunked coding is broken
  cut         ///< the client closed, or was too slow
};

/// Reads a request's body, however it is sent, and hands it on piece by piece. Neither the pieces nor what the
/// chunked coding adds to them can grow beyond bounds. `begun` is what arrived together with the head.
BodyEnd read_body(const Head& head, std::string begun, Socket& socket, std::uint64_t limit, const std::stop_token& stop,
                  const std::function<void(std::span<const char>)>& piece);

}  // namespace photond
