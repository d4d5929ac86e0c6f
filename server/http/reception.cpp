#include "server/http/reception.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "server/api/problem.h"
#include "server/http/body.h"
#include "server/http/origin.h"

namespace photond {

namespace {

constexpr const char* kSeatNames[] = {"requests", "uploads", "streams"};
constexpr std::chrono::seconds kContinueSeconds{5};

/// A media type or coding without its parameters, in lower case.
std::string bare(const std::string& value) {
  std::string type = value.substr(0, value.find(';'));
  while (!type.empty() && type.back() == ' ') type.pop_back();
  std::transform(type.begin(), type.end(), type.begin(), [](unsigned char c) { return std::tolower(c); });
  return type;
}

Response bad_head(const BadHead& bad) {
  const char* code = "invalid_request";
  if (bad.status == 414 || bad.status == 431) code = "limit_exceeded";
  if (bad.status > 500) code = "unsupported";
  return problem(bad.status, code, bad.detail);
}

Response too_large(std::uint64_t limit) {
  return problem(413, "limit_exceeded", "the body is larger than " + std::to_string(limit) + " bytes");
}

/// Why a body is refused before any of it is read, if it is.
std::optional<Response> refuse_body(const Head& head, const Route& route) {
  const std::string coding = bare(head.field("content-encoding"));
  if (!coding.empty() && coding != "identity") {
    return problem(415, "unsupported", "bodies must not have a Content-Encoding");
  }
  if (route.body_types.empty()) return std::nullopt;
  const std::string type = bare(head.field("content-type"));
  if (std::find(route.body_types.begin(), route.body_types.end(), type) == route.body_types.end()) {
    std::string accepted;
    for (const std::string& name : route.body_types) accepted += (accepted.empty() ? "" : ", ") + name;
    return problem(415, "unsupported", "the Content-Type must be one of: " + accepted);
  }
  if (!head.has_body()) return problem(411, "invalid_input", "the request has no body");
  if (head.length.value_or(0) > route.max_body_bytes) return too_large(route.max_body_bytes);
  return std::nullopt;
}

}  // namespace

std::shared_ptr<void> Reception::take(Seat seat) {
  if (seat == Seat::probe) return std::make_shared<int>();
  const auto kind = static_cast<std::size_t>(seat);
  if (taken_[kind].fetch_add(1) >= limits_[kind]) {
    taken_[kind].fetch_sub(1);
    return nullptr;
  }
  const int stream = seat == Seat::stream ? 1 : 0;
  counts_.streams_changed(stream);
  return {&taken_[kind], [this, stream](std::atomic<int>* taken) {
            counts_.streams_changed(-stream);
            taken->fetch_sub(1);
          }};
}

Served Reception::answer(Arrival& arrival, const std::string& path,
                         const std::multimap<std::string, std::string>& query, const std::string& id,
                         const std::stop_token& stop) {
  Served served;
  if (const auto* bad = std::get_if<BadHead>(&arrival.head)) {
    served.response = bad_head(*bad);
    return served;
  }
  const Head head = std::get<Head>(arrival.head);
  served = find(arrival, head, path, query, id, stop);
  cors_.mark(head, served.response);
  return served;
}

Served Reception::find(Arrival& arrival, const Head& head, const std::string& path,
                       const std::multimap<std::string, std::string>& query, const std::string& id,
                       const std::stop_token& stop) {
  Served served;
  const std::string method = head.method == "HEAD" ? "GET" : head.method;
  if (const auto refusal = refuse_origin(head, cors_, any_host_())) {
    served.response = problem(403, "forbidden", *refusal);
    return served;
  }
  const auto enter = [&](const std::string& route, Seat seat) {
    served.route = route;
    served.seat = take(seat);
    if (served.seat) return true;
    const std::string kind = kSeatNames[static_cast<std::size_t>(seat)];
    served.response = problem(503, "too_many_" + kind, "too many " + kind + " at once; try again");
    return false;
  };
  std::string allowed;
  const std::string* resource = nullptr;  // the first pattern that matches
  for (const Route& route : routes_) {
    auto captures = match_path(route.pattern, path);
    if (!captures || (resource != nullptr && *resource != route.pattern)) continue;
    resource = &route.pattern;
    if (route.method != method) {
      allowed += (allowed.empty() ? "" : ", ") + route.method + (route.method == "GET" ? ", HEAD" : "");
      continue;
    }
    if (!enter(route.pattern, query.contains("wait") ? Seat::stream : route.seat)) return served;
    Request request;
    request.captures = std::move(*captures);
    request.path = path;
    request.query = query;
    request.id = id;
    request.stop = stop;
    served.response = run(route, std::move(request), arrival, head);
    return served;
  }
  if (const Response* file = files_.find(path); file != nullptr && method == "GET") {
    if (enter("/", Seat::request)) served.response = *file;
    return served;
  }
  if (allowed.empty()) {
    served.response = problem(404, "not_found", "there is nothing at this path");
    return served;
  }
  if (auto preflight = cors_.preflight(head, allowed)) {
    served.response = std::move(*preflight);
    return served;
  }
  served.response = problem(405, "method_not_allowed", "this path takes only: " + allowed);
  served.response.headers.emplace_back("Allow", allowed);
  return served;
}

Response Reception::run(const Route& route, Request request, Arrival& arrival, const Head& head) {
  request.method = route.method;
  request.content_type = bare(head.field("content-type"));
  request.headers = head.fields;
  request.peer = arrival.peer;
  request.is_over = [&arrival] { return arrival.socket.peer_gone(); };
  if (auto refusal = route.admit(request)) return std::move(*refusal);
  if (auto refusal = take_body(route, arrival, head, request.stop, request.body)) return std::move(*refusal);
  return route.handler(request);
}

std::optional<Response> Reception::take_body(const Route& route, Arrival& arrival, const Head& head,
                                             const std::stop_token& stop, std::vector<std::byte>& body) {
  if (auto refusal = refuse_body(head, route)) return refusal;
  if (route.body_types.empty()) return std::nullopt;  // what comes is never read
  // A client that asks before it sends hears a refusal without sending.
  constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
  if (head.expects_continue &&
      !arrival.socket.write(kContinue.data(), kContinue.size(), std::chrono::steady_clock::now() + kContinueSeconds,
                            stop)) {
    return problem(400, "invalid_request", "the client went away");
  }
  const auto keep = [&](std::span<const char> piece) {
    const auto bytes = std::as_bytes(piece);
    body.insert(body.end(), bytes.begin(), bytes.end());
  };
  switch (read_body(head, std::move(arrival.body), arrival.socket, route.max_body_bytes, stop, keep)) {
    case BodyEnd::complete:
      return std::nullopt;
    case BodyEnd::too_large:
      return too_large(route.max_body_bytes);
    case BodyEnd::malformed:
      return problem(400, "invalid_request", "the chunked coding of the body is malformed");
    case BodyEnd::cut:
      return problem(400, "invalid_request", "the body ended early or took too long");
  }
  return std::nullopt;
}

}  // namespace photond
