#include "server/http/head.h"

#include <gtest/gtest.h>

namespace photond {
namespace {

constexpr const char* kHost = "Host: x\r\n";

Head good(const std::string& text) {
  const auto head = parse_head(text);
  EXPECT_TRUE(std::holds_alternative<Head>(head)) << text << std::get<BadHead>(head).detail;
  return std::holds_alternative<Head>(head) ? std::get<Head>(head) : Head{};
}

/// The status by which a head is refused; 0 where it is not.
int bad(const std::string& text) {
  const auto head = parse_head(text);
  return std::holds_alternative<BadHead>(head) ? std::get<BadHead>(head).status : 0;
}

/// Of a request line without its line end, and of what else is behind the Host.
int bad_line(const std::string& line, const std::string& fields = {}) {
  return bad(line + "\r\n" + kHost + fields + "\r\n");
}
int bad_fields(const std::string& fields) { return bad_line("POST /a HTTP/1.1", fields); }
int bad_target(const std::string& target) { return bad_line("GET " + target + " HTTP/1.1"); }

TEST(Head, IsReadAsSent) {
  const Head head = good("POST /v1/jobs?dry_run=true HTTP/1.1\r\nHost: x\r\nCoNtent-Type: \t application/json \r\n"
                         "Content-Length: 12\r\nExpect: 100-Continue\r\nAccept: a\r\naccept: b\r\nREMOTE_ADDR: 1.2.3.4\r\n"
                         "X: %0d%0aY: z\r\nEmpty:\r\n\r\n");
  EXPECT_EQ(head.method, "POST");
  EXPECT_EQ(head.target, "/v1/jobs?dry_run=true");
  EXPECT_EQ(head.field("content-type"), "application/json");
  EXPECT_EQ(head.field("accept"), "a, b");
  EXPECT_EQ(head.field("x"), "%0d%0aY: z") << "header values are not percent-decoded";
  EXPECT_EQ(head.field("empty"), "");
  EXPECT_EQ(head.field("absent"), "");
  EXPECT_EQ(head.length, 12u);
  EXPECT_TRUE(head.expects_continue);
  EXPECT_FALSE(head.chunked);
  EXPECT_FALSE(head.http10);
}

TEST(Head, KnowsHowLongTheBodyIs) {
  EXPECT_FALSE(good("GET / HTTP/1.1\r\nHost: x\r\n\r\n").has_body());
  EXPECT_FALSE(good("POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n").has_body());
  EXPECT_TRUE(good("POST / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: Chunked\r\n\r\n").chunked);
  EXPECT_TRUE(good("GET / HTTP/1.0\r\n\r\n").http10) << "HTTP/1.0 needs no Host";
}

TEST(Head, LengthsStatedTwiceAreRefused) {
  EXPECT_EQ(bad_fields("Content-Length: 5\r\nContent-Length: 5\r\n"), 400);
  EXPECT_EQ(bad_fields("Content-Length: 5\r\nContent-Length: 6\r\n"), 400);
  EXPECT_EQ(bad_fields("Content-Length: 5\r\nTransfer-Encoding: chunked\r\n"), 400);
  EXPECT_EQ(bad_fields("Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n"), 400);
  EXPECT_EQ(bad_fields("Transfer-Encoding: chunked, identity\r\n"), 501);
  EXPECT_EQ(bad_fields("Transfer-Encoding: gzip, chunked\r\n"), 501);
  EXPECT_EQ(bad_fields("Transfer-Encoding: xchunked\r\n"), 501);
  EXPECT_EQ(bad("POST / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n"), 400);
  for (const char* length : {"ten", "-1", "+1", "0x10", "1 2", "1,1", "", "9999999999999999999"}) {
    EXPECT_EQ(bad_fields("Content-Length: " + std::string(length) + "\r\n"), 400) << length;
  }
}

TEST(Head, WhatParsersReadDifferentlyIsRefused) {
  for (const char* fields :
       {"Content-Length : 5\r\n", "Transfer-Encoding:\x0b" "chunked\r\n", " Folded: 1\r\n", "A: 1\r\n B\r\n", "A: 1\n",
        "A: 1\rB: 2\r\n", "no colon\r\n", ": no name\r\n", "N\xc3\xa4me: 1\r\n", "A: \x7f\r\n", "Host: y\r\n",
        "Authorization: a\r\nAuthorization: b\r\n"}) {
    EXPECT_EQ(bad_fields(fields), 400) << fields;
  }
  EXPECT_EQ(bad(std::string("GET / HTTP/1.1\r\nHost: x\r\nA: \0\r\n\r\n", 33)), 400);
  EXPECT_EQ(bad("GET / HTTP/1.1\r\n\r\n"), 400) << "no Host";
  EXPECT_EQ(bad("GET / HTTP/1.1\nHost: x\n\n"), 400);
  EXPECT_EQ(bad("GET / HTTP/1.1"), 400) << "not even a line";
  EXPECT_EQ(bad(""), 400);
}

TEST(Head, RequestLinesAreChecked) {
  EXPECT_EQ(bad("GET /\r\n\r\n"), 400) << "HTTP/0.9";
  EXPECT_EQ(bad_line("GET  / HTTP/1.1"), 400);
  EXPECT_EQ(bad_line("GET / HTTP/2.0"), 505);
  EXPECT_EQ(bad_line("GET / HTTQ/1.1"), 400);
  EXPECT_EQ(bad_line("BREW / HTTP/1.1"), 501);
  EXPECT_EQ(bad_line("G(T / HTTP/1.1"), 400);
  EXPECT_EQ(bad("PRI * HTTP/2.0\r\n\r\n"), 505);
}

TEST(Head, TargetsAreChecked) {
  for (const char* target : {"*", "http://x/", "//x/../y\\\x01", "a", "/%", "/%0", "/%zz", "/%00", "/a%0d%0aX:y", "/%7f",
                             "/a#b", "/\xc3\xa4", "/?a=%0a"}) {
    EXPECT_EQ(bad_target(target), 400) << target;
  }
  for (const char* target : {"/", "/..", "/%2e%2e/x", "//etc/passwd", "/a%20b", "/?a=b+c%C3%A4", "/a?b?c"}) {
    EXPECT_EQ(bad_target(target), 0) << target;
  }
  EXPECT_EQ(bad_target("/" + std::string(512, 'a')), 414);
  EXPECT_EQ(bad_target("/?" + std::string(5000, 'a')), 414);
}

TEST(Head, HasAHundredLines) {
  std::string lines;
  for (int i = 0; i < 99; ++i) lines += "A" + std::to_string(i) + ": 1\r\n";
  EXPECT_EQ(bad_line("GET / HTTP/1.1", lines), 0);
  EXPECT_EQ(bad_line("GET / HTTP/1.1", lines + "B: 1\r\n"), 431);
}

}  // namespace
}  // namespace photond
