#include "server/http/body.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <vector>

namespace photond {

namespace {

constexpr std::size_t kBufferBytes = 64 * 1024;
constexpr std::size_t kMaxChunkLine = 64;       // sixteen digits and a short extension
constexpr std::uint64_t kMaxOverhead = 16ull << 20;  // all chunk lines together: no endless row of tiny chunks

/// The bytes of a connection in order: first what is there already, then the socket's.
class Source {
 public:
  Source(std::string begun, Socket& socket, const std::stop_token& stop) : socket_(socket), stop_(stop) {
    buffer_.assign(begun.begin(), begun.end());
  }

  /// At most `size` bytes, valid until the next call; empty where none come any more.
  std::span<const char> take(std::uint64_t size) {
    if (at_ == buffer_.size() && !fill()) return {};
    const std::size_t n = static_cast<std::size_t>(std::min<std::uint64_t>(size, buffer_.size() - at_));
    at_ += n;
    return std::span<const char>(buffer_).subspan(at_ - n, n);
  }

  /// A line without its CRLF.
  std::optional<std::string> line() {
    std::string text;
    while (text.size() <= kMaxChunkLine) {
      const auto next = take(1);
      if (next.empty()) return std::nullopt;
      text += next[0];
      if (next[0] != '\n') continue;
      if (!text.ends_with("\r\n")) return std::nullopt;
      return text.substr(0, text.size() - 2);
    }
    return std::nullopt;
  }

 private:
  bool fill() {
    buffer_.resize(kBufferBytes);
    at_ = 0;
    const long n = socket_.read(buffer_.data(), buffer_.size(), pace_.deadline(), stop_);
    buffer_.resize(static_cast<std::size_t>(std::max(0l, n)));
    pace_.moved(buffer_.size());
    return n > 0;
  }

  Socket& socket_;
  const std::stop_token& stop_;
  Pace pace_;
  std::vector<char> buffer_;
  std::size_t at_ = 0;
};

using Piece = std::function<void(std::span<const char>)>;

bool pass_on(Source& source, std::uint64_t size, const Piece& piece) {
  while (size > 0) {
    const std::span<const char> bytes = source.take(size);
    if (bytes.empty()) return false;
    piece(bytes);
    size -= bytes.size();
  }
  return true;
}

/// The size that a chunk's line states; extensions mean nothing to us.
std::optional<std::uint64_t> chunk_size(std::string_view line) {
  line = line.substr(0, line.find(';'));
  while (!line.empty() && (line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
  std::uint64_t size = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), size, 16);
  if (line.empty() || error != std::errc() || end != line.data() + line.size()) return std::nullopt;
  return size;
}

BodyEnd read_chunks(Source& source, std::uint64_t limit, const Piece& piece) {
  std::uint64_t total = 0;
  for (std::uint64_t overhead = 0; overhead <= kMaxOverhead;) {
    const auto line = source.line();
    const auto size = line ? chunk_size(*line) : std::nullopt;
    if (!size) return line ? BodyEnd::malformed : BodyEnd::cut;
    if (*size > limit - total) return BodyEnd::too_large;
    // Trailers are refused: nothing here reads them.
    if (*size == 0) return source.line() == "" ? BodyEnd::complete : BodyEnd::malformed;
    if (!pass_on(source, *size, piece)) return BodyEnd::cut;
    total += *size;
    if (source.line() != "") return BodyEnd::malformed;
    overhead += line->size() + 4;
  }
  return BodyEnd::malformed;
}

}  // namespace

BodyEnd read_body(const Head& head, std::string begun, Socket& socket, std::uint64_t limit, const std::stop_token& stop,
                  const Piece& piece) {
  Source source(std::move(begun), socket, stop);
  if (head.chunked) return read_chunks(source, limit, piece);
  const std::uint64_t length = head.length.value_or(0);
  if (length > limit) return BodyEnd::too_large;
  return pass_on(source, length, piece) ? BodyEnd::complete : BodyEnd::cut;
}

}  // namespace photond
