#include "server/store/uploads.h"

namespace photond {

Status check_uploads(Transaction& transaction, const std::string& owner, std::uint64_t more,
                     const std::optional<std::uint64_t>& limit) {
  if (!limit) return Done{};
  Query query = transaction.query(
      "SELECT coalesce(sum(bytes), 0) FROM (SELECT bytes FROM scenes WHERE owner = ?1 UNION ALL "
      "SELECT bytes FROM environments WHERE owner = ?1)",
      owner);
  const std::uint64_t taken = query.next() ? query.whole(0) : 0;
  if (const Status read = query.status(); !read) return read;
  if (taken + more <= *limit) return Done{};
  return Error{ErrorCode::limit_exceeded, "this key's scenes and environments would take more than it may; delete some",
               "disk"};
}

}  // namespace photond
