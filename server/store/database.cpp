#include "server/store/database.h"

#include <sqlite3.h>

#include <cerrno>
#include <utility>

#include "server/store/file.h"

namespace photond {

namespace {

constexpr std::int64_t kApplication = 0x50686f74;  // "Phot": PRAGMA application_id of photond's files

Error damaged(const std::string& path, const std::string& detail) {
  return {ErrorCode::io,
          "the database " + path + " is damaged (" + detail +
              "). Restore it from a backup, or move it aside, with its -wal and -shm files and the folders "
              "scenes, environments, frames and checkpoints, to start without them; nothing was changed",
          ""};
}

bool is_damage(int code) { return (code & 0xff) == SQLITE_CORRUPT || (code & 0xff) == SQLITE_NOTADB; }

}  // namespace

// --- Query --------------------------------------------------------------------------------------------------------

Query::Query(Transaction& transaction, std::string_view sql) : transaction_(&transaction) {
  Database& database = transaction.database_;
  auto found = database.idle_.find(sql);
  if (found == database.idle_.end()) {
    found = database.idle_.emplace(sql, nullptr);
    const int code = sqlite3_prepare_v3(database.connection_, sql.data(), static_cast<int>(sql.size()),
                                        SQLITE_PREPARE_PERSISTENT, &found->second, nullptr);
    if (code != SQLITE_OK) {
      database.idle_.erase(found);   // first: to tell why takes memory
      fail(code);
      return;
    }
  }
  taken_ = database.idle_.extract(found);
}

Query::~Query() {
  if (taken_.empty()) return;
  sqlite3_reset(statement());
  sqlite3_clear_bindings(statement());
  transaction_->database_.idle_.insert(std::move(taken_));
}

void Query::fail(int code) {
  if (!failure_) failure_ = transaction_->database_.failure(code);
}

bool Query::next() {
  if (failure_) return false;
  const int code = sqlite3_step(statement());
  if (code != SQLITE_ROW && code != SQLITE_DONE) fail(code);
  return code == SQLITE_ROW;
}

void Query::bind_value(std::int64_t value) {
  if (failure_) return;
  if (const int code = sqlite3_bind_int64(statement(), ++bound_, value); code != SQLITE_OK) fail(code);
}

void Query::bind_value(double value) {
  if (failure_) return;
  if (const int code = sqlite3_bind_double(statement(), ++bound_, value); code != SQLITE_OK) fail(code);
}

void Query::bind_value(std::string_view value) {
  if (failure_) return;
  const int code =
      sqlite3_bind_text64(statement(), ++bound_, value.data(), value.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  if (code != SQLITE_OK) fail(code);
}

void Query::bind_value(std::span<const std::byte> value) {
  if (failure_) return;
  // A null pointer would bind NULL.
  const void* data = value.empty() ? static_cast<const void*>("") : value.data();
  const int code = sqlite3_bind_blob64(statement(), ++bound_, data, value.size(), SQLITE_TRANSIENT);
  if (code != SQLITE_OK) fail(code);
}

void Query::bind_null() {
  if (failure_) return;
  if (const int code = sqlite3_bind_null(statement(), ++bound_); code != SQLITE_OK) fail(code);
}

std::int64_t Query::integer(int column) const { return sqlite3_column_int64(statement(), column); }
double Query::real(int column) const { return sqlite3_column_double(statement(), column); }

std::string Query::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement(), column));
  if (text == nullptr) return {};
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(statement(), column))};
}

std::vector<std::byte> Query::bytes(int column) const {
  const auto* begin = static_cast<const std::byte*>(sqlite3_column_blob(statement(), column));
  if (begin == nullptr) return {};
  return {begin, begin + sqlite3_column_bytes(statement(), column)};
}

// --- Database -----------------------------------------------------------------------------------------------------

Result<std::unique_ptr<Database>> Database::open(const std::string& path,
                                                 std::span<const Migration> migrations) {
  sqlite3* connection = nullptr;
  // The mutex of this class is the only one needed.
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  const int code = sqlite3_open_v2(path.c_str(), &connection, flags, nullptr);
  std::unique_ptr<Database> database(new Database(connection));
  if (connection == nullptr) return Error{ErrorCode::io, "cannot open the database " + path, ""};
  if (code != SQLITE_OK) return database->failure(code);
  sqlite3_extended_result_codes(connection, 1);
  Status ready = database->set_up();
  if (ready) ready = database->check();
  if (ready) ready = database->migrate(migrations);
  if (!ready) return ready.error();
  return database;
}

Database::~Database() {
  for (const auto& [sql, statement] : idle_) sqlite3_finalize(statement);
  sqlite3_close(connection_);
}

Status Database::set_up() {
  for (const char* sql : {"PRAGMA journal_mode = WAL", "PRAGMA synchronous = FULL", "PRAGMA foreign_keys = ON",
                          "PRAGMA secure_delete = OFF", "PRAGMA temp_store = MEMORY"}) {
    if (const Status set = execute(sql); !set) return set;
  }
  return Done{};
}

Status Database::check() {
  const Result<std::int64_t> owner = number_of("PRAGMA application_id");
  if (!owner) return owner.error();
  const Result<std::int64_t> tables = number_of("SELECT count(*) FROM sqlite_master");
  if (!tables) return tables.error();
  const std::string path = sqlite3_db_filename(connection_, "main");
  if (*owner != kApplication && (*owner != 0 || *tables != 0)) {
    return Error{ErrorCode::io, "the database " + path + " is not photond's; choose another data directory", ""};
  }
  std::string said;
  const Status asked = read([&](Transaction& transaction) {
    Query query = transaction.query("PRAGMA quick_check(1)");
    if (query.next()) said = query.text(0);
    return query.status();
  });
  if (!asked) return asked;
  return said == "ok" ? Status(Done{}) : damaged(path, said);
}

Status Database::migrate(std::span<const Migration> migrations) {
  const Result<std::int64_t> version = number_of("PRAGMA user_version");
  if (!version) return version.error();
  const auto newest = static_cast<std::int64_t>(migrations.size());
  if (*version > newest) {
    return Error{ErrorCode::io,
                 "the data directory was written by a newer photond (its tables have version " +
                     std::to_string(*version) + ", this program knows " + std::to_string(newest) +
                     "); run the newer program, or choose another data directory",
                 ""};
  }
  if (*version == newest) return Done{};
  return write([&](Transaction&) -> Status {
    for (std::int64_t step = *version; step < newest; ++step) {
      if (const Status done = execute(migrations[static_cast<std::size_t>(step)].sql); !done) return done;
    }
    const std::string stamp = "PRAGMA user_version = " + std::to_string(newest) +
                              "; PRAGMA application_id = " + std::to_string(kApplication);
    return execute(stamp.c_str());
  });
}

Status Database::write(const Body& body, Durability durability) {
  const std::lock_guard lock(mutex_);
  if (durability != durability_) {
    // In WAL mode NORMAL does not wait for the disk at a commit; the next FULL one syncs the whole log.
    const bool full = durability == Durability::full;
    const Status set = execute(full ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = NORMAL");
    if (!set) return set;
    durability_ = durability;
  }
  return in_transaction("BEGIN IMMEDIATE", body);
}

Status Database::read(const Body& body) {
  const std::lock_guard lock(mutex_);
  return in_transaction("BEGIN", body);
}

Status Database::in_transaction(const char* begin, const Body& body) {
  if (const Status begun = execute(begin); !begun) return begun;
  Transaction transaction(*this);
  Status done = Done{};
  try {
    done = body(transaction);
    if (done) done = execute("COMMIT");
  } catch (...) {  // out of memory and the like: whoever called may go on
    (void)roll_back().ok();
    throw;
  }
  if (done) return done;
  const Status undone = roll_back();
  return undone ? done : undone;
}

/// Some failures have rolled back already.
Status Database::roll_back() {
  return sqlite3_get_autocommit(connection_) == 0 ? execute("ROLLBACK") : Status(Done{});
}

Status Database::execute(const char* sql) {
  const int code = sqlite3_exec(connection_, sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return failure(code);
  return Done{};
}

Result<std::int64_t> Database::number_of(const char* sql) {
  std::int64_t number = 0;
  const Status asked = read([&](Transaction& transaction) {
    Query query = transaction.query(sql);
    if (query.next()) number = query.integer(0);
    return query.status();
  });
  if (!asked) return asked.error();
  return number;
}

Error Database::failure(int code) const {
  if (is_damage(code)) return damaged(sqlite3_db_filename(connection_, "main"), sqlite3_errmsg(connection_));
  const std::string message = "the database cannot be used: " + std::string(sqlite3_errmsg(connection_));
  const int number = sqlite3_system_errno(connection_);
  const bool io = (code & 0xff) == SQLITE_IOERR || (code & 0xff) == SQLITE_CANTOPEN;
  if ((code & 0xff) == SQLITE_FULL || (io && (number == ENOSPC || number == EDQUOT))) return disk_full(message);
  if (io && (number == EMFILE || number == ENFILE)) return disk_unreachable(message);
  return {ErrorCode::io, message, ""};
}

}  // namespace photond
