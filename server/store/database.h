#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace photond {

/// One step forward of the tables: SQL statements. Step i leads from version i to i + 1 (PRAGMA user_version);
/// see schema.h for how to add one.
struct Migration {
  const char* sql = "";
};

class Transaction;

/// By their SQL; one that is in use is taken out, so that giving it back needs no memory.
using PreparedStatements = std::multimap<std::string, sqlite3_stmt*, std::less<>>;

/// One use of a prepared statement.
class Query {
 public:
  Query(Query&&) noexcept = default;
  Query& operator=(Query&&) = delete;
  ~Query();  ///< gives the statement back

  /// Moves to the next row; false at the end and on an error, which `status` tells apart.
  bool next();
  Status status() const { return failure_ ? Status(*failure_) : Status(Done{}); }

  /// The columns of the present row, from 0. NULL reads as 0 or empty.
  std::int64_t integer(int column) const;
  std::uint64_t whole(int column) const { return static_cast<std::uint64_t>(integer(column)); }
  double real(int column) const;
  std::string text(int column) const;
  std::vector<std::byte> bytes(int column) const;

 private:
  friend class Transaction;
  Query(Transaction& transaction, std::string_view sql);

  void bind_value(std::int64_t value);
  void bind_value(double value);
  void bind_value(std::string_view value);
  void bind_value(std::span<const std::byte> value);
  void bind_null();

  template <class T>
  void bind(const T& value) {
    if constexpr (std::is_integral_v<T> || std::is_enum_v<T>) {
      bind_value(static_cast<std::int64_t>(value));
    } else if constexpr (std::is_floating_point_v<T>) {
      bind_value(static_cast<double>(value));
    } else if constexpr (std::convertible_to<T, std::string_view>) {
      bind_value(std::string_view(value));
    } else {
      bind_value(std::span<const std::byte>(value));
    }
  }
  template <class T>
  void bind(const std::optional<T>& value) {
    if (value) return bind(*value);
    bind_null();
  }

  void fail(int code);
  sqlite3_stmt* statement() const { return taken_.mapped(); }

  Transaction* transaction_;
  PreparedStatements::node_type taken_;   ///< out of the database's; empty after a failure
  int bound_ = 0;
  std::optional<Error> failure_;
};

class Database;

/// What may be done while the database is held.
class Transaction {
 public:
  /// A statement with its parameters: whole numbers (64 bits), floating-point numbers, enums, text, bytes
  /// (anything that is a span of std::byte) and optionals of them, nothing being NULL.
  template <class... Values>
  Query query(std::string_view sql, const Values&... values) {
    Query query(*this, sql);
    (query.bind(values), ...);
    return query;
  }
  /// Runs a statement that gives no rows.
  template <class... Values>
  Status run(std::string_view sql, const Values&... values) {
    Query done = query(sql, values...);
    done.next();
    return done.status();
  }

 private:
  friend class Database;
  friend class Query;
  explicit Transaction(Database& database) : database_(database) {}
  Database& database_;
};

/// How long a commit may take to be on the disk.
enum class Durability : std::uint8_t {
  full,     ///< at once: what has been told to a client must have this
  relaxed,  ///< with the next full one. Survives the process (kill -9), but not a loss of power; never out of order
};

/// One SQLite file with one connection, used by one thread at a time. WAL, synchronous = FULL.
class Database {
 public:
  using Body = std::function<Status(Transaction&)>;

  /// Opens or creates the file, checks it, and brings its tables forward, in one transaction, to
  /// `migrations.size()`. Errors: io, saying what to do, for a file that is damaged, of a newer photond or not
  /// photond's; system_error.
  static Result<std::unique_ptr<Database>> open(const std::string& path, std::span<const Migration> migrations);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Runs `body` in one transaction: kept where it and the commit succeed, undone otherwise, also where it throws.
  /// Must not be called from within a body. Errors: the body's; limit_exceeded with `where` "disk" (file.h); io.
  Status write(const Body& body, Durability durability = Durability::full);
  /// Runs `body`, which changes nothing, on one state of the database.
  Status read(const Body& body);

 private:
  friend class Query;
  friend class Transaction;
  explicit Database(sqlite3* connection) : connection_(connection) {}

  Status execute(const char* sql);
  Result<std::int64_t> number_of(const char* sql);
  Status check();
  Status set_up();
  Status migrate(std::span<const Migration> migrations);
  Status in_transaction(const char* begin, const Body& body);
  Status roll_back();
  Error failure(int code) const;

  std::mutex mutex_;
  sqlite3* connection_;
  Durability durability_ = Durability::full;
  PreparedStatements idle_;
};

}  // namespace photond
