#include "server/http/body.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <thread>

namespace photond {
namespace {

struct Got {
  BodyEnd end;
  std::string body;
};

Head head_of(const std::string& field) {
  return std::get<Head>(parse_head("POST / HTTP/1.1\r\nHost: x\r\n" + field + "\r\n\r\n"));
}

/// Reads a body of which `begun` is there and `rest` comes in small pieces before the other end closes.
Got read(const Head& head, const std::string& begun, const std::string& rest, std::uint64_t limit = 1000) {
  int ends[2];
  EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  Socket mine(ends[0]);
  ::fcntl(mine.fd(), F_SETFL, O_NONBLOCK);
  std::thread writer([other = Socket(ends[1]), &rest] {
    for (std::size_t at = 0; at < rest.size(); at += 3) ::send(other.fd(), rest.data() + at, std::min<std::size_t>(3, rest.size() - at), MSG_NOSIGNAL);
  });
  Got got{BodyEnd::complete, {}};
  got.end = read_body(head, begun, mine, limit, {}, [&](std::span<const char> piece) { got.body.append(piece.data(), piece.size()); });
  mine = Socket();
  writer.join();
  return got;
}

TEST(Body, OfAStatedLengthIsReadToItsEnd) {
  const Head ten = head_of("Content-Length: 10");
  EXPECT_EQ(read(ten, "", "0123456789").body, "0123456789");
  EXPECT_EQ(read(ten, "0123", "456789next").body, "0123456789");
  EXPECT_EQ(read(ten, "0123456789next", "").body, "0123456789");
  EXPECT_EQ(read(ten, "0123", "45").end, BodyEnd::cut);
  EXPECT_EQ(read(ten, "", "0123456789", 9).end, BodyEnd::too_large);
  EXPECT_EQ(read(head_of("X: none"), "", "junk").body, "");
}

TEST(Body, InChunksIsReadToItsEnd) {
  const Head chunked = head_of("Transfer-Encoding: chunked");
  const std::string coded = "5\r\nabcde\r\nA;name=value\r\n0123456789\r\n0\r\n\r\n";
  for (std::size_t split = 0; split <= coded.size(); ++split) {
    const Got got = read(chunked, coded.substr(0, split), coded.substr(split) + "next");
    EXPECT_EQ(got.end, BodyEnd::complete) << split;
    EXPECT_EQ(got.body, "abcde0123456789") << split;
  }
  for (std::size_t size = 0; size < coded.size(); ++size) {
    EXPECT_NE(read(chunked, "", coded.substr(0, size)).end, BodyEnd::complete) << size;
  }
}

TEST(Body, ChunksCannotGrowBeyondTheLimit) {
  const Head chunked = head_of("Transfer-Encoding: chunked");
  EXPECT_EQ(read(chunked, "", "5\r\nabcde\r\n6\r\nabcdef\r\n0\r\n\r\n", 10).end, BodyEnd::too_large);
  EXPECT_EQ(read(chunked, "", "ffffffffffffffff\r\n").end, BodyEnd::too_large);
  EXPECT_EQ(read(chunked, "", "5\r\nabcde\r\nfffffffffffffffe\r\n", 10).end, BodyEnd::too_large) << "no overflow";
  EXPECT_EQ(read(chunked, "", "5\r\nabcde\r\n5\r\nabcde\r\n0\r\n\r\n", 10).end, BodyEnd::complete);
}

}  // namespace
}  // namespace photond
