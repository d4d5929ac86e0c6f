#include "server/api/range.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace photond {
namespace {

/// What a request for `range` gets of "0123456789": the status, and what the body holds.
std::pair<int, std::string> ask(const std::string& range, const std::string& condition = {}) {
  Response whole;
  whole.headers.emplace_back("ETag", "\"v1\"");
  const test::TemporaryFolder folder;
  std::ofstream(folder.file("digits")) << "(0123456789)";
  const auto file = std::make_shared<const File>(std::move(*File::open(folder.file("digits"), O_RDONLY)));
  whole.body = FileBytes{file, 1, 10};
  Request request;
  if (!range.empty()) request.headers["range"] = range;
  if (!condition.empty()) request.headers["if-range"] = condition;
  const Response got = ranged(request, whole);
  std::string text;
  if (const auto* part = std::get_if<FileBytes>(&got.body)) {
    text.resize(part->length);
    EXPECT_TRUE(part->file->read_at(std::as_writable_bytes(std::span(text)), part->first).ok());
  }
  for (const auto& [name, value] : got.headers) {
    if (name == "Content-Range") text += " " + value;
  }
  return {got.status, got.status == 416 ? text.substr(text.find("bytes")) : text};
}

using Got = std::pair<int, std::string>;

TEST(Range, OneRangeIsServed) {
  EXPECT_EQ(ask("bytes=0-0"), Got(206, "0 bytes 0-0/10"));
  EXPECT_EQ(ask("bytes=2-4"), Got(206, "234 bytes 2-4/10"));
  EXPECT_EQ(ask("bytes=7-"), Got(206, "789 bytes 7-9/10"));
  EXPECT_EQ(ask("bytes=-3"), Got(206, "789 bytes 7-9/10"));
  EXPECT_EQ(ask("bytes=-99"), Got(206, "0123456789 bytes 0-9/10"));
  EXPECT_EQ(ask("bytes=5-99999999999"), Got(206, "56789 bytes 5-9/10"));
}

TEST(Range, WhereNothingLiesIsSaidSo) {
  EXPECT_EQ(ask("bytes=10-"), Got(416, "bytes */10"));
  EXPECT_EQ(ask("bytes=10-20"), Got(416, "bytes */10"));
  EXPECT_EQ(ask("bytes=-0"), Got(416, "bytes */10"));
}

TEST(Range, WhatCannotBeReadGetsTheWhole) {
  for (const char* range : {"", "bytes=", "bytes=-", "bytes=a-b", "bytes=3-1", "bytes=0-1,3-4", "lines=0-1", "bytes=0-1-2",
                            "bytes= 0-1", "bytes=99999999999999999999-", "bytes=+1-2"}) {
    EXPECT_EQ(ask(range), Got(200, "0123456789")) << range;
  }
}

TEST(Range, IfRangeGuardsAgainstOtherBytes) {
  EXPECT_EQ(ask("bytes=0-1", "\"v1\"").first, 206);
  EXPECT_EQ(ask("bytes=0-1", "\"v2\"").first, 200);
}

}  // namespace
}  // namespace photond
