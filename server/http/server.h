#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/api/request_counts.h"
#include "server/http/reception.h"
#include "server/http/route_table.h"
#include "server/http/static_files.h"

namespace photond {

struct HttpOptions {
  std::string host = "127.0.0.1";
  int port = 0;  ///< 0: any free port
  Seats seats;
  std::chrono::milliseconds patience{10'000};  ///< for a request's head to arrive
  Cors cors;
  /// Whether it answers by whatever name it is asked (see refuse_origin), at this moment.
  std::function<bool()> any_host = [] { return true; };
};

/// HTTP/1.1: a doorman, a reception, a crew of threads, and cpp-httplib between them. Knows routes only as a table,
/// and answers what is not in it from the files of the web client. One request per connection.
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
