#include "server/store/answers.h"

#include <algorithm>
#include <span>

namespace photond {

namespace {

std::int64_t milliseconds(WallTime time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
}

}  // namespace

Result<std::optional<StoredAnswer>> Answers::find(const std::string& owner, const std::string& key,
                                                  WallTime now) const {
  std::optional<StoredAnswer> found;
  const Status read = database_.read([&](Transaction& transaction) -> Status {
    Query row = transaction.query(
        "SELECT request, job, etag, status, body FROM answers WHERE owner = ? AND key = ? AND created_ms > ?", owner,
        key, milliseconds(now - kLifetime));
    if (!row.next()) return row.status();
    StoredAnswer answer;
    const std::vector<std::byte> request = row.bytes(0);
    if (request.size() != sizeof answer.request.bytes) return Error{ErrorCode::io, "a stored answer is damaged", ""};
    std::copy(request.begin(), request.end(), reinterpret_cast<std::byte*>(answer.request.bytes.data()));
    answer.job = row.text(1);
    answer.etag = row.text(2);
    answer.status = static_cast<int>(row.integer(3));
    answer.body = row.text(4);
    found = std::move(answer);
    return Done{};
  });
  if (!read) return read.error();
  return found;
}

Status Answers::put(Transaction& transaction, const std::string& owner, const std::string& key,
                    const StoredAnswer& answer, WallTime now) {
  const Status forgotten = transaction.run("DELETE FROM answers WHERE created_ms <= ?", milliseconds(now - kLifetime));
  if (!forgotten) return forgotten;
  return transaction.run("INSERT INTO answers VALUES (?, ?, ?, ?, ?, ?, ?, ?)", owner, key,
                         std::as_bytes(std::span(answer.request.bytes)), answer.job, answer.etag, answer.status,
                         answer.body, milliseconds(now));
}

}  // namespace photond
