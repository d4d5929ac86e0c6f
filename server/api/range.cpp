#include "server/api/range.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "server/api/etag.h"
#include "server/api/problem.h"
#include "server/api/query.h"

namespace photond {

namespace {

/// First and last byte of one range over `size` bytes; the last is at least the first.
struct Range {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

/// What `text` names. Nothing where it cannot be read; `unsatisfiable` where it can, and nothing lies there.
std::optional<Range> parse_range(std::string_view text, std::uint64_t size, bool& unsatisfiable) {
  constexpr std::string_view kUnit = "bytes=";
  if (!text.starts_with(kUnit)) return std::nullopt;
  text.remove_prefix(kUnit.size());
  const std::size_t dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const auto first = parse_whole(text.substr(0, dash));
  const auto last = parse_whole(text.substr(dash + 1));
  if ((!first && dash != 0) || (!last && dash + 1 != text.size()) || (!first && !last)) return std::nullopt;
  if (first && last && *last < *first) return std::nullopt;
  unsatisfiable = first ? *first >= size : *last == 0 || size == 0;
  if (unsatisfiable) return std::nullopt;
  if (!first) return Range{size - std::min(size, *last), size - 1};  // the last so many bytes
  return Range{*first, std::min(last.value_or(size - 1), size - 1)};
}

}  // namespace

Response ranged(const Request& request, Response whole) {
  whole.headers.emplace_back("Accept-Ranges", "bytes");
  const std::string text = request.header("range");
  const std::string condition = request.header("if-range");
  if (text.empty() || (!condition.empty() && condition != etag_of(whole))) return whole;
  FileBytes& bytes = std::get<FileBytes>(whole.body);
  const std::string size = std::to_string(bytes.length);
  bool unsatisfiable = false;
  const auto range = parse_range(text, bytes.length, unsatisfiable);
  if (unsatisfiable) {
    Response refusal = problem(416, "range_not_satisfiable", "there are " + size + " bytes");
    refusal.headers.emplace_back("Content-Range", "bytes */" + size);
    return refusal;
  }
  if (!range) return whole;
  whole.status = 206;
  whole.headers.emplace_back("Content-Range",
                             "bytes " + std::to_string(range->first) + "-" + std::to_string(range->last) + "/" + size);
  bytes = {bytes.file, bytes.first + range->first, range->last - range->first + 1};
  return whole;
}

}  // namespace photond
