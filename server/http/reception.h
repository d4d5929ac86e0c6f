#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "server/api/request_counts.h"
#include "server/http/cors.h"
#include "server/http/doorman.h"
#include "server/http/route_table.h"
#include "server/http/static_files.h"

namespace photond {

/// How many of each kind are served at once; beyond it the answer is 503.
struct Seats {
  int streams = 512;
  int uploads = 8;
  int requests = 64;
};

/// An answer and what it stands for.
struct Served {
  Response response;
  std::string route = "other";   ///< the pattern that matched
  std::shared_ptr<void> seat;   ///< given back when the last copy goes
};

/// Finds who answers a request, checks what any route would have to check, reads the body. Knows no library.
class Reception {
 public:
  /// `any_host` tells whether the service may be asked by whatever name (see refuse_origin). `counts` must outlive the
  /// object.
  Reception(const Seats& seats, std::vector<Route> routes, StaticFiles files, Cors cors, std::function<bool()> any_host,
            RequestCounts& counts)
      : limits_{seats.requests, seats.uploads, seats.streams}, routes_(std::move(routes)), files_(std::move(files)),
        cors_(std::move(cors)), any_host_(std::move(any_host)), counts_(counts) {}

  /// Answers `arrival`, whose target decodes to `path` and `query`. Throws nothing of its own, but handlers may.
  Served answer(Arrival& arrival, const std::string& path, const std::multimap<std::string, std::string>& query,
                const std::string& id, const std::stop_token& stop);

 private:
  Served find(Arrival& arrival, const Head& head, const std::string& path,
              const std::multimap<std::string, std::string>& query, const std::string& id, const std::stop_token& stop);
  Response run(const Route& route, Request request, Arrival& arrival, const Head& head);
  std::shared_ptr<void> take(Seat seat);
  static std::optional<Response> take_body(const Route& route, Arrival& arrival, const Head& head,
                                           const std::stop_token& stop, std::vector<std::byte>& body);

  const std::array<int, 3> limits_;  ///< by Seat
  std::array<std::atomic<int>, 3> taken_{};
  const std::vector<Route> routes_;
  const StaticFiles files_;
  const Cors cors_;
  const std::function<bool()> any_host_;
  RequestCounts& counts_;
};

}  // namespace photond
