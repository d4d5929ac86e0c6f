#include "server/http/server.h"

#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>
#include <stop_token>
#include <thread>

#include "server/api/problem.h"

namespace photond {

namespace {

constexpr std::size_t kSliceBytes = 256 * 1024;
constexpr std::size_t kMaxPath = 512;
constexpr std::size_t kMaxHeaders = 100;
constexpr std::uint64_t kMaxIgnoredBody = 64 * 1024;  // of a route that takes no body
constexpr std::uint64_t kMaxDrain = 64 << 20;         // read and dropped so that a refusal is seen
constexpr int kSpareThreads = 16;                     // for answering 503 when all slots are taken
constexpr int kBacklog = 512;
constexpr int kFirstByteSeconds = 5;
constexpr int kReadSeconds = 5;
constexpr int kWriteSeconds = 15;

const std::vector<std::pair<std::string, std::string>> kSecurityHeaders{
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; object-src 'none'; "
     "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"}};

/// One of a limited number of places; given back when the last copy goes.
using Slot = std::shared_ptr<void>;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string lower_type(const std::string& header) {
  std::string type = header.substr(0, header.find(';'));
  while (!type.empty() && type.back() == ' ') type.pop_back();
  return lower(std::move(type));
}

/// What a request says of its body. The library trusts these headers, so they are checked here.
struct BodyClaim {
  bool present = false;
  std::optional<std::uint64_t> length;  ///< unknown where chunked
};

Result<BodyClaim> claimed_body(const httplib::Request& in) {
  const bool chunked = in.has_header("Transfer-Encoding");
  const std::size_t lengths = in.get_header_value_count("Content-Length");
  if (lengths > 1 || (chunked && lengths > 0)) return invalid_input("the length of the body is stated twice");
  if (chunked) {
    if (lower_type(in.get_header_value("Transfer-Encoding")) != "chunked") {
      return invalid_input("only the transfer encoding chunked is supported");
    }
    return BodyClaim{true, std::nullopt};
  }
  if (lengths == 0) return BodyClaim{};
  const std::string text = in.get_header_value("Content-Length");
  const bool digits = !text.empty() && text.size() <= 18 &&
                      std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
  if (!digits) return invalid_input("Content-Length is not a number");
  const std::uint64_t length = std::stoull(text);
  return BodyClaim{length > 0, length};
}

bool is_identity(const httplib::Request& in) {
  const std::string encoding = lower_type(in.get_header_value("Content-Encoding"));
  return encoding.empty() || encoding == "identity";
}

Response too_large(std::uint64_t limit) {
  return problem(413, "limit_exceeded", "the body is larger than " + std::to_string(limit) + " bytes");
}

/// Why a body is refused before any of it is read, if it is.
std::optional<Response> refuse_body(const httplib::Request& in, const Route& route, const BodyClaim& claim) {
  if (!is_identity(in)) return problem(415, "unsupported", "bodies must not have a Content-Encoding");
  if (route.body_types.empty()) return std::nullopt;
  const std::string type = lower_type(in.get_header_value("Content-Type"));
  if (std::find(route.body_types.begin(), route.body_types.end(), type) == route.body_types.end()) {
    std::string accepted;
    for (const std::string& name : route.body_types) accepted += (accepted.empty() ? "" : ", ") + name;
    return problem(415, "unsupported", "the Content-Type must be one of: " + accepted);
  }
  if (!claim.present) return problem(411, "invalid_input", "the request has no body");
  if (claim.length && *claim.length > route.max_body_bytes) return too_large(route.max_body_bytes);
  return std::nullopt;
}

void write_headers(const Response& from, httplib::Response& out) {
  out.status = from.status;
  for (const auto& [name, value] : kSecurityHeaders) out.set_header(name, value);
  for (const auto& [name, value] : from.headers) out.set_header(name, value);
}

/// Bodies leave through content providers in slices: memory stays small for slow readers, and the library
/// never compresses them, so that a strong ETag names exactly these bytes.
void write_bytes(const SharedBytes& bytes, const std::string& type, const Slot& slot, httplib::Response& out) {
  if (bytes->empty()) {
    if (!type.empty()) out.set_content(std::string(), type);
    return;
  }
  out.set_content_provider(bytes->size(), type,
                           [bytes, slot](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                             if (offset >= bytes->size()) return false;
                             const std::size_t n = std::min({length, kSliceBytes, bytes->size() - offset});
                             return sink.write(reinterpret_cast<const char*>(bytes->data()) + offset, n);
                           });
}

SharedBytes to_bytes(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return std::make_shared<const std::vector<std::byte>>(begin, begin + text.size());
}

void write_stream(Pieces pieces, const std::string& type, const Slot& slot, std::stop_token stop,
                  httplib::Response& out) {
  out.set_chunked_content_provider(type, [pieces, slot, stop](std::size_t, httplib::DataSink& sink) {
    try {  // what leaves a provider ends the process
      const std::optional<std::string> piece = stop.stop_requested() ? std::nullopt : pieces();
      if (!piece) {
        sink.done();
        return true;
      }
      return piece->empty() || sink.write(piece->data(), piece->size());
    } catch (const std::exception&) {
      return false;
    }
  });
}

}  // namespace

struct HttpServer::State {
  State(const HttpOptions& o, std::vector<Route> r, StaticFiles f, RequestCounts& c)
      : options(o), routes(std::move(r)), files(std::move(f)), counts(c) {}

  void configure();
  Status bind();
  void answer(const httplib::Request& in, httplib::Response& out, const httplib::ContentReader* reader);
  Response dispatch(const httplib::Request& in, const httplib::ContentReader* reader, std::string& route,
                    Slot& slot);
  Response run(const Route& route, Request request, const httplib::Request& in,
               const httplib::ContentReader* reader);
  /// Returns why the request is refused, by `refusal` or its body.
  std::optional<Response> read_body(const Route& route, const httplib::Request& in,
                                    const httplib::ContentReader* reader, std::optional<Response> refusal,
                                    std::vector<std::byte>& body);
  Slot take_slot(bool waits);
  void write(const Response& from, const Slot& slot, httplib::Response& out);

  const HttpOptions options;
  const std::vector<Route> routes;
  const StaticFiles files;
  RequestCounts& counts;
  std::atomic<int> open_streams{0};
  std::atomic<int> open_requests{0};
  std::stop_source stopping;
  socket_t listening = -1;
  int port = 0;
  httplib::Server server;
  std::thread thread;
};

void HttpServer::State::configure() {
  const int threads = options.max_streams + options.max_requests + kSpareThreads;
  server.new_task_queue = [threads] { return new httplib::ThreadPool(static_cast<std::size_t>(threads)); };
  server.set_keep_alive_max_count(1);
  server.set_keep_alive_timeout(kFirstByteSeconds);
  server.set_read_timeout(kReadSeconds, 0);
  server.set_write_timeout(kWriteSeconds, 0);
  server.set_tcp_nodelay(true);
  // The library's own choice is SO_REUSEPORT, by which two services would share a port unnoticed.
  server.set_socket_options([this](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    listening = socket;
  });
  using Next = httplib::Server::HandlerResponse;
  server.set_pre_routing_handler([this](const httplib::Request& in, httplib::Response& out) {
    // Ranges are optional in HTTP, and the library's handling of several is a gift to attackers. The request
    // is its own mutable local.
    const_cast<httplib::Request&>(in).ranges.clear();
    const bool plain_path = in.path.size() <= kMaxPath && in.path.find('\n') == std::string::npos &&
                            in.path.find('\r') == std::string::npos;
    if (in.method == "POST" && plain_path) return Next::Unhandled;  // only a content reader may read bodies
    answer(in, out, nullptr);
    return Next::Handled;
  });
  server.Post(".*", [this](const httplib::Request& in, httplib::Response& out,
                           const httplib::ContentReader& reader) { answer(in, out, &reader); });
  // A client that asks before it sends hears a refusal without sending.
  server.set_expect_100_continue_handler([this](const httplib::Request& in, httplib::Response& out) {
    for (const Route& route : routes) {
      if (route.method != in.method || !match_path(route.pattern, in.path)) continue;
      const Result<BodyClaim> claim = claimed_body(in);
      const auto refusal =
          claim ? refuse_body(in, route, *claim) : problem(400, "invalid_request", claim.error().message);
      if (!refusal) return 100;
      write(*refusal, nullptr, out);
      return refusal->status;
    }
    return 100;
  });
  server.set_exception_handler([this](const httplib::Request&, httplib::Response& out, std::exception_ptr) {
    write(problem(500, "internal", "the request could not be handled"), nullptr, out);
  });
  server.set_error_handler([this](const httplib::Request&, httplib::Response& out) {
    if (out.has_header("Content-Type")) return;  // ours; what is left are the library's own refusals
    const int status = out.status;
    write(problem(status, "invalid_request", "the request is malformed or not supported"), nullptr, out);
  });
}

Status HttpServer::State::bind() {
  errno = 0;
  const bool any = options.port == 0;
  port = any ? server.bind_to_any_port(options.host) : options.port;
  const bool bound = any ? port > 0 : server.bind_to_port(options.host, options.port);
  if (!bound) {
    const std::string reason = errno != 0 ? std::strerror(errno) : "the address cannot be used";
    return Error{ErrorCode::io,
                 "cannot listen on " + options.host + ":" + std::to_string(options.port) + ": " + reason, ""};
  }
  ::listen(listening, kBacklog);  // again: the library's backlog of 5 refuses bursts
  return Done{};
}

Slot HttpServer::State::take_slot(bool waits) {
  std::atomic<int>& open = waits ? open_streams : open_requests;
  const int limit = waits ? options.max_streams : options.max_requests;
  if (open.fetch_add(1) >= limit) {
    open.fetch_sub(1);
    counts.refused();
    return nullptr;
  }
  if (waits) counts.streams_changed(1);
  return Slot(&open, [this, waits](void* counter) {
    if (waits) counts.streams_changed(-1);
    static_cast<std::atomic<int>*>(counter)->fetch_sub(1);
  });
}

void HttpServer::State::answer(const httplib::Request& in, httplib::Response& out,
                               const httplib::ContentReader* reader) {
  std::string route = "other";
  Slot slot;
  Response response;
  try {
    response = dispatch(in, reader, route, slot);
  } catch (const std::exception&) {  // out of memory and the like; the text is nobody's business
    response = problem(500, "internal", "the request could not be handled");
  }
  const bool known = in.method == "GET" || in.method == "HEAD" || in.method == "POST" || in.method == "DELETE";
  counts.answered(known ? in.method : "other", route, response.status);
  write(response, slot, out);
}

Response HttpServer::State::dispatch(const httplib::Request& in, const httplib::ContentReader* reader,
                                     std::string& route_name, Slot& slot) {
  if (in.path.size() > kMaxPath) return problem(414, "limit_exceeded", "the path is too long");
  if (in.headers.size() > kMaxHeaders) return problem(431, "limit_exceeded", "too many header lines");
  const std::string method = in.method == "HEAD" ? "GET" : in.method;
  if (method != "GET" && lower_type(in.get_header_value("Sec-Fetch-Site")) == "cross-site") {
    return problem(403, "forbidden", "other sites may not change anything here");
  }
  std::string allowed;
  for (const Route& route : routes) {
    auto captures = match_path(route.pattern, in.path);
    if (!captures) continue;
    if (route.method != method) {
      allowed += (allowed.empty() ? "" : ", ") + route.method;
      continue;
    }
    route_name = route.pattern;
    slot = take_slot(route.streams || in.has_param("wait"));
    if (!slot) return problem(503, "overloaded", "too many requests at once; try again");
    Request request;
    request.captures = std::move(*captures);
    return run(route, std::move(request), in, reader);
  }
  if (const Response* file = files.find(in.path); file != nullptr && method == "GET") {
    route_name = "/";
    slot = take_slot(false);
    return slot ? *file : problem(503, "overloaded", "too many requests at once; try again");
  }
  if (allowed.empty()) return problem(404, "not_found", "there is nothing at this path");
  Response refusal = problem(405, "method_not_allowed", "this path takes only: " + allowed);
  refusal.headers.emplace_back("Allow", allowed);
  return refusal;
}

Response HttpServer::State::run(const Route& route, Request request, const httplib::Request& in,
                                const httplib::ContentReader* reader) {
  request.method = route.method;
  request.path = in.path;
  request.query.insert(in.params.begin(), in.params.end());
  request.content_type = lower_type(in.get_header_value("Content-Type"));
  for (const auto& [name, value] : in.headers) request.headers.emplace(lower(name), value);
  request.peer = in.remote_addr;
  request.stop = stopping.get_token();
  std::optional<Response> refusal = route.admit(request);
  if ((refusal = read_body(route, in, reader, std::move(refusal), request.body))) return std::move(*refusal);
  return route.handler(request);
}

std::optional<Response> HttpServer::State::read_body(const Route& route, const httplib::Request& in,
                                                     const httplib::ContentReader* reader,
                                                     std::optional<Response> refusal,
                                                     std::vector<std::byte>& body) {
  if (reader == nullptr) return refusal;
  const Result<BodyClaim> claim = claimed_body(in);
  if (!claim) return problem(400, "invalid_request", claim.error().message);
  if (!refusal) refusal = refuse_body(in, route, *claim);
  if (!claim->present || !is_identity(in) || in.is_multipart_form_data()) return refusal;
  // A refused body is still read, up to a point: closing on unread bytes would reset the connection before the
  // client sees why.
  const std::uint64_t limit = route.body_types.empty() ? kMaxIgnoredBody : route.max_body_bytes;
  const bool wanted = !refusal && !route.body_types.empty();
  if (wanted && claim->length) body.reserve(*claim->length);
  std::uint64_t total = 0;
  const bool complete = (*reader)([&](const char* data, std::size_t size) {
    total += size;
    if (total > limit && !refusal) {
      refusal = too_large(limit);
      body = {};
    }
    if (refusal) return total <= limit + kMaxDrain;
    if (!wanted) return true;
    const auto* begin = reinterpret_cast<const std::byte*>(data);
    body.insert(body.end(), begin, begin + size);
    return true;
  });
  if (refusal) return refusal;
  if (!complete) return problem(400, "invalid_request", "the body ended early or took too long");
  return std::nullopt;
}

void HttpServer::State::write(const Response& from, const Slot& slot, httplib::Response& out) {
  write_headers(from, out);
  if (const auto* text = std::get_if<std::string>(&from.body)) {
    write_bytes(to_bytes(*text), from.content_type, slot, out);
  } else if (const auto* bytes = std::get_if<SharedBytes>(&from.body)) {
    write_bytes(*bytes, from.content_type, slot, out);
  } else {
    write_stream(std::get<Pieces>(from.body), from.content_type, slot, stopping.get_token(), out);
  }
}

Result<std::unique_ptr<HttpServer>> HttpServer::start(const HttpOptions& options, std::vector<Route> routes,
                                                      StaticFiles files, RequestCounts& counts) {
  auto state = std::make_unique<State>(options, std::move(routes), std::move(files), counts);
  state->configure();
  if (const Status bound = state->bind(); !bound) return bound.error();
  state->thread = std::thread([raw = state.get()] { raw->server.listen_after_bind(); });
  // stop() has no effect before the loop runs; connections are accepted already.
  while (!state->server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(state)));
}

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
HttpServer::~HttpServer() { stop(); }

int HttpServer::port() const { return state_->port; }

void HttpServer::stop() {
  state_->stopping.request_stop();
  state_->server.stop();
  if (state_->thread.joinable()) state_->thread.join();
}

}  // namespace photond
