#include "server/http/server.h"

#include <httplib.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <random>
#include <stop_token>
#include <utility>

#include "server/api/problem.h"
#include "server/http/crew.h"
#include "server/http/doorman.h"
#include "server/log.h"

// How cpp-httplib is used here: the doorman accepts connections and reads heads, the reception finds the handler and
// reads bodies, so that the library meets neither a socket nor a byte that was not checked. It takes the request line
// apart (path, percent-decoding, query) and writes the answer. One request per connection: what follows a request is
// never taken for the next one.

namespace photond {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kPieceBytes = 256 * 1024;
constexpr int kSpareThreads = 64;  // for probes, and for refusing what finds no seat
constexpr std::chrono::seconds kStreamPatience{15};  // for a viewer to take what it was sent
constexpr std::size_t kMaxId = 64;

const std::vector<std::pair<std::string, std::string>> kSecurityHeaders{
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; object-src 'none'; "
     "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"}};

/// The request line as the library shall see it, without header lines: what those say has been read already. A head
/// that is refused has none.
std::string canonical_head(const Arrival& arrival) {
  const Head* head = std::get_if<Head>(&arrival.head);
  if (head == nullptr) return "GET / HTTP/1.1\r\n\r\n";
  return head->method + " " + head->target + " HTTP/1.1\r\n\r\n";
}

/// A connection as the library sees it: it reads a prepared text and writes to the socket, each within its time.
class Conversation final : public httplib::Stream {
 public:
  Conversation(Arrival& arrival, const std::stop_token& stop)
      : arrival_(arrival), stop_(stop), text_(canonical_head(arrival)) {}

  /// From here on the answer has no end: every piece has its own time.
  void become_stream() { stream_ = true; }
  std::uint64_t written() const { return written_; }
  bool failed() const { return failed_; }
  bool peer_gone() const { return arrival_.socket.peer_gone(); }

  bool is_readable() const override { return at_ < text_.size(); }
  bool is_writable() const override { return !failed_; }
  ssize_t read(char* to, size_t size) override {
    const std::size_t n = text_.copy(to, size, at_);
    at_ += n;
    return static_cast<ssize_t>(n);
  }
  ssize_t write(const char* from, size_t size) override {
    const SteadyTime deadline = stream_ ? Clock::now() + kStreamPatience : pace_.deadline();
    failed_ = failed_ || !arrival_.socket.write(from, size, deadline, stop_);
    if (failed_) return -1;
    pace_.moved(size);
    written_ += size;
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip = arrival_.peer;
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    ip.clear();
    port = 0;
  }
  // The library must not touch the socket; a number that it would not select() on anyway.
  socket_t socket() const override { return 0; }

 private:
  Arrival& arrival_;
  const std::stop_token& stop_;
  const std::string text_;
  std::size_t at_ = 0;
  Pace pace_;
  std::uint64_t written_ = 0;
  bool stream_ = false;
  bool failed_ = false;
};

/// One request's way through the library. An object of its own costs little, and shares nothing.
class Exchange : private httplib::Server {
 public:
  using Answerer = std::function<void(const httplib::Request&, httplib::Response&)>;

  explicit Exchange(Answerer answerer) {
    svr_sock_ = 0;  // else it takes itself for shutting down; it is never listened on
    set_pre_routing_handler([answerer](const httplib::Request& in, httplib::Response& out) {
      answerer(in, out);
      return HandlerResponse::Handled;
    });
    // Where there can be no body its length is not told (RFC 9110, 8.6): the library would say 0.
    set_post_routing_handler([](const httplib::Request&, httplib::Response& out) {
      if (out.status == 204 || out.status == 304) out.headers.erase("Content-Length");
    });
    // What it refuses itself, with a body of ours.
    set_error_handler([answerer](const httplib::Request& in, httplib::Response& out) {
      if (!out.has_header("X-Request-Id")) answerer(in, out);
    });
  }

  void run(Conversation& conversation, const std::string& peer) { run(*this, conversation, peer); }

 private:
  /// cpp-httplib 0.18 takes addresses here, 0.11 asks the stream for them.
  template <class Self>
  static void run(Self& self, Conversation& conversation, const std::string& peer) {
    bool closed = false;
    if constexpr (requires { self.process_request(conversation, peer, 0, peer, 0, true, closed, nullptr); }) {
      self.process_request(conversation, peer, 0, peer, 0, true, closed, nullptr);
    } else {
      self.process_request(conversation, true, closed, nullptr);
    }
  }
};

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// The client's own X-Request-Id where it is harmless, else a new one.
std::string request_id(const Arrival& arrival) {
  const Head* head = std::get_if<Head>(&arrival.head);
  const std::string given = head != nullptr ? head->field("x-request-id") : std::string();
  const bool harmless = !given.empty() && given.size() <= kMaxId && std::all_of(given.begin(), given.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
  });
  if (harmless) return given;
  thread_local std::mt19937_64 random{std::random_device{}()};
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string id(16, '0');
  std::uint64_t bits = random();
  for (char& digit : id) {
    digit = kDigits[bits & 15];
    bits >>= 4;
  }
  return id;
}

SharedBytes to_bytes(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return std::make_shared<const std::vector<std::byte>>(begin, begin + text.size());
}

/// Gives the sink `length` bytes of a body, at most kPieceBytes, from `offset` on; false where that cannot be. Throws
/// nothing: that would end the process.
using Give = std::function<bool(std::size_t offset, std::size_t length, httplib::DataSink& sink)>;

Give from_memory(SharedBytes bytes) {
  return [bytes = std::move(bytes)](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
    return sink.write(reinterpret_cast<const char*>(bytes->data()) + offset, length);
  };
}

Give from_file(const FileBytes& bytes) {
  const auto piece = std::make_shared<std::vector<std::byte>>(std::min<std::uint64_t>(kPieceBytes, bytes.length));
  return [bytes, piece](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
    const std::span<std::byte> wanted(piece->data(), length);
    return bytes.file->read_at(wanted, bytes.first + offset).ok() &&
           sink.write(reinterpret_cast<const char*>(wanted.data()), length);
  };
}

/// Bodies leave in pieces, by content providers, which the library never compresses: a strong ETag names exactly
/// these bytes. The seat is kept until the last byte has left.
void write_bytes(std::size_t size, Give give, const std::string& type, const std::shared_ptr<void>& seat,
                 httplib::Response& out) {
  if (size == 0) {
    if (!type.empty()) out.set_content(std::string(), type);
    return;
  }
  const auto provider = [size, give = std::move(give), seat](std::size_t offset, std::size_t length,
                                                             httplib::DataSink& sink) {
    return offset < size && give(offset, std::min({length, kPieceBytes, size - offset}), sink);
  };
  out.set_content_provider(size, type, provider);
}

void write_stream(Pieces pieces, const std::string& type, const std::shared_ptr<void>& seat, Conversation& conversation,
                  const std::stop_token& stop, bool http10, httplib::Response& out) {
  conversation.become_stream();
  const auto provider = [pieces = std::move(pieces), seat, &conversation, stop](std::size_t, httplib::DataSink& sink) {
    try {  // what leaves a provider ends the process
      if (conversation.peer_gone()) return false;
      const std::optional<std::string> piece = stop.stop_requested() ? std::nullopt : pieces();
      if (!piece) {
        sink.done();
        return true;
      }
      return piece->empty() || sink.write(piece->data(), piece->size());
    } catch (const std::exception&) {
      return false;
    }
  };
  if (http10) {
    out.set_content_provider(type, provider);  // ends with the connection
  } else {
    out.set_chunked_content_provider(type, provider);
  }
}

}  // namespace

struct HttpServer::State {
  State(const HttpOptions& options, std::vector<Route> routes, StaticFiles files, RequestCounts& c)
      : counts(c),
        reception(options.seats, std::move(routes), std::move(files), options.cors, options.any_host, c),
        crew(static_cast<std::size_t>(options.seats.streams + options.seats.uploads + options.seats.requests + kSpareThreads)) {}

  bool enter(Arrival&& arrival);
  void serve(Arrival& arrival);
  void answer(Arrival& arrival, const httplib::Request& in, Conversation& conversation, httplib::Response& out,
              LogLine& line);

  RequestCounts& counts;
  Reception reception;
  Crew crew;
  std::stop_source stopping;
  std::unique_ptr<Doorman> doorman;
};

bool HttpServer::State::enter(Arrival&& arrival) {
  const auto taken = std::make_shared<Arrival>(std::move(arrival));
  if (crew.start([this, taken] { serve(*taken); })) return true;
  counts.answered({"other", "other", 503}, "too_many_threads", 0);
  arrival = std::move(*taken);
  return false;
}

void HttpServer::State::serve(Arrival& arrival) {
  try {
    const Clock::time_point begin = Clock::now();
    const std::stop_token stop = stopping.get_token();
    LogLine line(LogLevel::info, "request");
    Conversation conversation(arrival, stop);
    Exchange exchange([&](const httplib::Request& in, httplib::Response& out) { answer(arrival, in, conversation, out, line); });
    exchange.run(conversation, arrival.peer);
    line.with("bytes", conversation.written()).with("complete", !conversation.failed()).with("seconds", seconds_since(begin));
  } catch (const std::exception& failure) {  // out of memory, outside any handler
    counts.dropped("exception");
    LogLine(LogLevel::error, "exception").with("what", failure.what());
  }
  doorman->see_out(std::move(arrival.socket));
}

void HttpServer::State::answer(Arrival& arrival, const httplib::Request& in, Conversation& conversation,
                               httplib::Response& out, LogLine& line) {
  const Clock::time_point begin = Clock::now();
  const std::string id = request_id(arrival);
  // What the library itself cannot read it has given a status.
  if (out.status >= 400) arrival.head = BadHead{400, "the request is malformed"};
  Served served;
  try {
    served = reception.answer(arrival, in.path, in.params, id, stopping.get_token());
  } catch (const std::exception& failure) {  // out of memory and the like; the text is no client's business
    LogLine(LogLevel::error, "exception").with("request", id).with("what", failure.what());
    served.response = problem(500, "internal", "the request could not be handled");
  }
  const Response& response = served.response;
  const Head* head = std::get_if<Head>(&arrival.head);
  const std::string method = head != nullptr ? head->method : "other";
  counts.answered({method, served.route, response.status}, response.refusal, seconds_since(begin));
  line.with("request", id).with("peer", arrival.peer).with("method", method).with("route", served.route);
  if (head != nullptr) line.with("path", in.path);  // without the query, which is the client's own
  line.with("status", response.status);
  if (!response.refusal.empty()) line.with("refusal", response.refusal);
  out.status = response.status;
  out.set_header("X-Request-Id", id);
  for (const auto& [name, value] : kSecurityHeaders) out.set_header(name, value);
  for (const auto& [name, value] : response.headers) {
    out.set_header(name, value);
    if (name == "Location") line.with("location", value);  // says which job a request made
  }
  // Else the library would offer what a GET does not.
  if (in.method == "HEAD" && !out.has_header("Accept-Ranges")) out.set_header("Accept-Ranges", "none");
  if (const auto* text = std::get_if<std::string>(&response.body)) {
    write_bytes(text->size(), from_memory(to_bytes(*text)), response.content_type, served.seat, out);
  } else if (const auto* bytes = std::get_if<SharedBytes>(&response.body)) {
    write_bytes((*bytes)->size(), from_memory(*bytes), response.content_type, served.seat, out);
  } else if (const auto* file = std::get_if<FileBytes>(&response.body)) {
    write_bytes(file->length, from_file(*file), response.content_type, served.seat, out);
  } else {
    write_stream(std::get<Pieces>(response.body), response.content_type, served.seat, conversation,
                 stopping.get_token(), head != nullptr && head->http10, out);
  }
}

Result<std::unique_ptr<HttpServer>> HttpServer::start(const HttpOptions& options, std::vector<Route> routes,
                                                      StaticFiles files, RequestCounts& counts) {
  auto state = std::make_unique<State>(options, std::move(routes), std::move(files), counts);
  DoormanOptions door;
  door.host = options.host;
  door.port = options.port;
  door.patience = options.patience;
  Result<std::unique_ptr<Doorman>> doorman = Doorman::open(door);
  if (!doorman) return doorman.error();
  state->doorman = std::move(*doorman);
  Doorman::Calls calls;
  calls.enter = [raw = state.get()](Arrival&& arrival) { return raw->enter(std::move(arrival)); };
  calls.lost = [&counts](Doorman::Loss loss) {
    constexpr const char* kReasons[] = {"slow", "crowded", "descriptors", "exception"};
    counts.dropped(kReasons[static_cast<int>(loss)]);
  };
  state->doorman->begin(std::move(calls));
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(state)));
}

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
HttpServer::~HttpServer() { stop(); }

int HttpServer::port() const { return state_->doorman->port(); }

void HttpServer::stop() {
  state_->stopping.request_stop();
  state_->doorman->close();
  state_->crew.stop();
}

}  // namespace photond
