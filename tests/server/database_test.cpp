#include "server/store/database.h"

#include <gtest/gtest.h>

#include <fstream>
#include <new>
#include <thread>

#include "server/store/schema.h"
#include "tests/support/temporary_folder.h"

namespace photond {
namespace {

constexpr Migration kFirst{"CREATE TABLE things (id INTEGER PRIMARY KEY, name TEXT, size REAL, data BLOB)"};
constexpr Migration kSecond{"ALTER TABLE things ADD COLUMN colour TEXT; CREATE TABLE others (id INTEGER)"};

class DatabaseTest : public ::testing::Test {
 protected:
  std::string path() const { return folder_.file("test.db"); }

  std::unique_ptr<Database> open(std::vector<Migration> migrations = {kFirst}) {
    auto database = Database::open(path(), migrations);
    EXPECT_TRUE(database.ok()) << database.error().message;
    return database ? std::move(*database) : nullptr;
  }

  std::string refusal(std::vector<Migration> migrations = {kFirst}) {
    const auto database = Database::open(path(), migrations);
    EXPECT_FALSE(database.ok());
    return database ? "" : database.error().message;
  }

  static std::int64_t count(Database& database, const std::string& table = "things") {
    std::int64_t rows = -1;
    const Status asked = database.read([&](Transaction& transaction) {
      Query query = transaction.query("SELECT count(*) FROM " + table);
      if (query.next()) rows = query.integer(0);
      return query.status();
    });
    EXPECT_TRUE(asked.ok());
    return rows;
  }

  static Status add(Database& database, int id) {
    return database.write([&](Transaction& transaction) {
      return transaction.run("INSERT INTO things (id) VALUES (?)", id);
    });
  }

  const test::TemporaryFolder folder_;
};

TEST_F(DatabaseTest, ValuesReadBackAsTheyWereBound) {
  const auto database = open();
  const std::vector<std::byte> data{std::byte{0}, std::byte{255}, std::byte{0}};
  const std::string name("with\0zero", 9);
  const Status written = database->write([&](Transaction& transaction) {
    const Status first = transaction.run("INSERT INTO things VALUES (?, ?, ?, ?)", UINT64_MAX, name, 0.1, data);
    if (!first) return first;
    return transaction.run("INSERT INTO things VALUES (?, ?, ?, ?)", 2, std::optional<std::string>(),
                           std::optional<double>(), std::vector<std::byte>());
  });
  ASSERT_TRUE(written.ok()) << written.error().message;
  const Status read = database->read([&](Transaction& transaction) {
    Query query = transaction.query("SELECT id, name, size, data FROM things ORDER BY id");
    EXPECT_TRUE(query.next());
    EXPECT_EQ(query.whole(0), UINT64_MAX);
    EXPECT_EQ(query.text(1), name);
    EXPECT_EQ(query.real(2), 0.1);
    EXPECT_EQ(query.bytes(3), data);
    EXPECT_TRUE(query.next());
    EXPECT_FALSE(query.next());
    Query nulls = transaction.query("SELECT name IS NULL, size IS NULL, data IS NULL FROM things WHERE id = 2");
    EXPECT_TRUE(nulls.next());
    EXPECT_EQ(nulls.integer(0), 1);
    EXPECT_EQ(nulls.integer(1), 1);
    EXPECT_EQ(nulls.integer(2), 0) << "no bytes are something else than nothing";
    return query.status();
  });
  EXPECT_TRUE(read.ok());
}

TEST_F(DatabaseTest, ATransactionIsKeptWholeOrNotAtAll) {
  const auto database = open();
  ASSERT_TRUE(add(*database, 1).ok());
  const Status refused = database->write([&](Transaction& transaction) -> Status {
    const Status first = transaction.run("INSERT INTO things (id) VALUES (2)");
    EXPECT_TRUE(first.ok());
    return transaction.run("INSERT INTO things (id) VALUES (1)");
  });
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::io);
  const Status changed_mind = database->write([&](Transaction& transaction) -> Status {
    const Status first = transaction.run("INSERT INTO things (id) VALUES (3)");
    EXPECT_TRUE(first.ok());
    return Error{ErrorCode::conflict, "no", ""};
  });
  EXPECT_EQ(changed_mind.error().code, ErrorCode::conflict);
  EXPECT_EQ(count(*database), 1);
  EXPECT_TRUE(add(*database, 2).ok()) << "the next transaction is not hindered";
}

TEST_F(DatabaseTest, ATransactionThatThrowsIsUndone) {
  const auto database = open();
  const auto out_of_memory = [](Transaction& transaction) -> Status {
    EXPECT_TRUE(transaction.run("INSERT INTO things (id) VALUES (1)").ok());
    throw std::bad_alloc();
  };
  EXPECT_THROW((void)database->write(out_of_memory), std::bad_alloc);
  EXPECT_EQ(count(*database), 0);
  EXPECT_TRUE(add(*database, 1).ok()) << "the next transaction is not hindered";
}

TEST_F(DatabaseTest, MistakesInSqlAreErrors) {
  const auto database = open();
  const Status wrong = database->read([](Transaction& transaction) {
    Query query = transaction.query("SELECT nothing FROM nowhere");
    EXPECT_FALSE(query.next());
    return query.status();
  });
  EXPECT_FALSE(wrong.ok());
  EXPECT_FALSE(
      database->write([](Transaction& t) { return t.run("DELETE FROM things WHERE id = ?", 1, 2); }).ok())
      << "more values than parameters";
}

TEST_F(DatabaseTest, TwoQueriesOfOneStatementDoNotMix) {
  const auto database = open();
  for (int id = 1; id <= 3; ++id) ASSERT_TRUE(add(*database, id).ok());
  const Status read = database->read([](Transaction& transaction) {
    Query outer = transaction.query("SELECT id FROM things ORDER BY id");
    int rows = 0;
    while (outer.next()) {
      Query inner = transaction.query("SELECT id FROM things ORDER BY id");
      while (inner.next()) ++rows;
    }
    EXPECT_EQ(rows, 9);
    return outer.status();
  });
  EXPECT_TRUE(read.ok());
}

TEST_F(DatabaseTest, KeepsWhatWasWrittenAndSharesItAmongThreads) {
  {
    const auto database = open();
    std::vector<std::thread> threads;
    for (int thread = 0; thread < 4; ++thread) {
      threads.emplace_back([&, thread] {
        for (int i = 0; i < 10; ++i) EXPECT_TRUE(add(*database, 100 * thread + i).ok());
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  EXPECT_EQ(count(*open()), 40);
}

TEST_F(DatabaseTest, ARelaxedTransactionIsOrderedBeforeALaterFullOne) {
  {
    const auto database = open();
    const auto insert = [](Transaction& t) { return t.run("INSERT INTO things (name) VALUES ('x')"); };
    EXPECT_TRUE(database->write(insert, Durability::relaxed).ok());
    EXPECT_TRUE(database->write(insert).ok());
    EXPECT_TRUE(database->write(insert, Durability::relaxed).ok());
  }
  EXPECT_EQ(count(*open()), 3);
}

TEST_F(DatabaseTest, MigratesForwardAndKeepsTheData) {
  EXPECT_TRUE(add(*open(), 7).ok());
  const auto database = open({kFirst, kSecond});
  EXPECT_EQ(count(*database), 1);
  EXPECT_EQ(count(*database, "others"), 0);
}

TEST_F(DatabaseTest, AFailingMigrationChangesNothing) {
  EXPECT_TRUE(add(*open(), 7).ok());
  EXPECT_NE(refusal({kFirst, kSecond, Migration{"CREATE TABLE things (id INTEGER)"}}), "");
  EXPECT_EQ(count(*open()), 1) << "still at the first version";
}

TEST_F(DatabaseTest, RefusesToGoBack) {
  open({kFirst, kSecond}).reset();
  EXPECT_NE(refusal().find("newer photond"), std::string::npos);
  open({kFirst, kSecond});
}

TEST_F(DatabaseTest, RefusesAFileThatIsNoDatabase) {
  std::ofstream(path(), std::ios::binary) << std::string(10'000, 'x');
  EXPECT_NE(refusal().find("is damaged"), std::string::npos);
  EXPECT_NE(refusal().find("move it aside"), std::string::npos);
}

TEST_F(DatabaseTest, RefusesADatabaseOfSomethingElse) {
  {
    const auto database = open();
    EXPECT_TRUE(database->write([](Transaction& t) { return t.run("PRAGMA application_id = 5"); }).ok());
  }
  EXPECT_NE(refusal().find("not photond's"), std::string::npos);
}

TEST_F(DatabaseTest, FindsADamagedPageAtTheStart) {
  {
    const auto database = open();
    const Status filled = database->write([](Transaction& transaction) -> Status {
      for (int i = 0; i < 2000; ++i) {
        const Status added = transaction.run("INSERT INTO things (name) VALUES (?)", std::string(100, 'a'));
        if (!added) return added;
      }
      return Done{};
    });
    ASSERT_TRUE(filled.ok());
  }  // closing moves the log into the file
  const auto size = std::filesystem::file_size(path());
  ASSERT_GT(size, 100'000u);
  for (std::uint64_t at = 4096 + 8; at + 64 < size; at += 4096) {  // every page but the first
    std::fstream file(path(), std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(at));
    file << std::string(64, '\x7f');
  }
  const std::string said = refusal();
  EXPECT_NE(said.find("is damaged"), std::string::npos) << said;
}

TEST_F(DatabaseTest, TheSchemaOpensAFreshAndAKnownFile) {
  for (int i = 0; i < 2; ++i) {
    const auto database = Database::open(path(), schema());
    ASSERT_TRUE(database.ok()) << database.error().message;
    EXPECT_EQ(count(**database, "jobs"), 0);
  }
}

}  // namespace
}  // namespace photond
