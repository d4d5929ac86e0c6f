#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "core/base/digest.h"
#include "server/store/database.h"
#include "server/store/records.h"

namespace photond {

/// What was answered to a request that carried an idempotency key, to be answered again.
struct StoredAnswer {
  Digest request;  ///< SHA-256 of its body
  std::string job;
  std::string etag;
  int status = 0;
  std::string body;
};

/// The table of answers by idempotency key. Each API key (empty: none was needed) has names of its own, and an answer
/// outlives its job. Thread-safe.
class Answers {
 public:
  static constexpr std::chrono::hours kLifetime{24};

  /// `database` must have the tables of schema() and outlive the object.
  explicit Answers(Database& database) : database_(database) {}

  /// Nothing where there is none, or it is too old at `now`. Errors: io.
  Result<std::optional<StoredAnswer>> find(const std::string& owner, const std::string& key, WallTime now) const;
  /// Adds an answer as a part of the transaction that does what it tells of, and forgets those that are too old.
  static Status put(Transaction& transaction, const std::string& owner, const std::string& key,
                    const StoredAnswer& answer, WallTime now);

 private:
  Database& database_;
};

}  // namespace photond
