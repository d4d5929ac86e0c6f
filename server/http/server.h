#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/api/request_counts.h"
#include "server/http/route_table.h"
#include "server/http/static_files.h"

namespace photond {

struct HttpOptions {
  std::string host = "127.0.0.1";
  int port = 0;           ///< 0: any free port
  int max_streams = 256;  ///< endless bodies and long polls at once
  int max_requests = 64;  ///< other requests at once
};

/// HTTP/1.1 by cpp-httplib: sockets, threads, sizes, headers. Knows routes only as a table, and answers what
/// is not in it from the files of the web client. One request per connection: an unread body can then never be
/// taken for the next request, and no idle connection holds a thread for long.
class HttpServer {
 public:
  /// Binds and serves. `counts` must outlive the server. Errors: io where the port cannot be had.
  static Result<std::unique_ptr<HttpServer>> start(const HttpOptions& options, std::vector<Route> routes,
                                                   StaticFiles files, RequestCounts& counts);
  ~HttpServer();

  int port() const;
  /// Ends streams and long polls, lets short requests finish, joins all threads.
  void stop();

 private:
  struct State;
  explicit HttpServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace photond
