#include "coordinator/study/database.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

constexpr int kApplicationId = 0x436F7070;  // "Copp"
// 2: other draws for roll-outs than before; 3: fronts, and the archive of a checkpoint; 4: the problem
constexpr int kSchemaVersion = 4;
constexpr int kProblemVersion = 4;
constexpr int kOldestVersion = 3;  // read as it is, and brought up to date when it is opened to write

constexpr const char* kSchema = R"(
CREATE TABLE study(
  id             INTEGER PRIMARY KEY CHECK(id = 1),
  created        TEXT NOT NULL,     -- UTC
  chain_hash     TEXT NOT NULL,     -- XXH3-128 of chain
  chain          BLOB NOT NULL,     -- common/chain/chain_bytes.hpp
  world_kind     TEXT NOT NULL,
  world_room     TEXT NOT NULL,
  learn_settings TEXT NOT NULL,     -- JSON
  learn_outcome  TEXT NOT NULL,     -- JSON
  problem        TEXT NOT NULL DEFAULT '' -- JSON, coordinator/problem/problem.hpp; empty: that of the world
) STRICT;
CREATE TABLE runs(
  id          INTEGER PRIMARY KEY AUTOINCREMENT,
  seed        TEXT NOT NULL,        -- unsigned, 64 bits
  config      TEXT NOT NULL,        -- JSON
  evaluator   TEXT NOT NULL,
  status      TEXT NOT NULL CHECK(status IN ('running', 'finished', 'interrupted', 'failed')),
  started     TEXT NOT NULL,        -- UTC
  ended       TEXT,                 -- UTC; NULL while running
  tree        TEXT,                 -- as evolved
  pruned      TEXT,
  result      TEXT NOT NULL DEFAULT '{}',  -- JSON
  owner_host  TEXT NOT NULL,
  owner_boot  TEXT NOT NULL,
  owner_space TEXT NOT NULL,
  owner_pid   INTEGER NOT NULL,
  owner_start TEXT NOT NULL
) STRICT;
CREATE TABLE generations(
  run            INTEGER NOT NULL REFERENCES runs(id),
  generation     INTEGER NOT NULL,  -- from 0
  best_tree      TEXT NOT NULL,
  best_fitness   REAL NOT NULL,
  best_agreement REAL NOT NULL,
  best_nodes     INTEGER NOT NULL,
  mean_fitness   REAL NOT NULL,
  mean_agreement REAL NOT NULL,
  mean_nodes     REAL NOT NULL,
  distinct_trees INTEGER NOT NULL,
  evaluations    INTEGER NOT NULL,
  seconds        REAL NOT NULL,
  PRIMARY KEY(run, generation)
) STRICT;
CREATE TABLE checkpoints(
  run         INTEGER PRIMARY KEY REFERENCES runs(id),
  generation  INTEGER NOT NULL,
  population  TEXT NOT NULL,        -- a line an individual, by slot: fitness, tab, tree
  archive     TEXT NOT NULL,        -- a line a tree kept on the front, as above with fitness 0; empty: no front
  hash        TEXT NOT NULL         -- XXH3-128 of population and archive
) STRICT;
CREATE TABLE fronts(
  run      INTEGER NOT NULL REFERENCES runs(id),
  position INTEGER NOT NULL,        -- from 0: fewer nodes first
  tree     TEXT NOT NULL,
  fitness  REAL NOT NULL,
  measures TEXT NOT NULL,           -- JSON: the value of each measure by its name
  PRIMARY KEY(run, position)
) STRICT;
)";

int busy_timeout_ms() { return static_cast<int>(kBusyTimeout.count()); }

tl::unexpected<Error> not_a_study(const std::string& path, const std::string& what) {
  return bad_input(fmt::format("{}: {}: expected a study, as 'coppice learn' makes it", path, what));
}

Result<void> check_file(const std::string& path, bool write) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    return bad_input(fmt::format("{}: {}: expected a study, as 'coppice learn' makes it", path, std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode)) {
    return not_a_study(path, "not a file");
  }
  if (status.st_size == 0) {
    return not_a_study(path, "is empty");
  }
  if (::access(path.c_str(), write ? R_OK | W_OK : R_OK) != 0) {
    return failed(fmt::format("{}: cannot be {}: {}", path, write ? "written" : "read", std::strerror(errno)));
  }
  return {};
}

int pragma(SQLite::Database& database, const char* name) {
  return database.execAndGet(fmt::format("PRAGMA {}", name)).getInt();
}

// SQLite fills a last page that is cut short with zeros and does not say so. While there is a log, that is what
// counts, so only a file at rest is measured.
Result<void> check_length(const std::string& path, SQLite::Database& database) {
  struct stat status {};
  const bool at_rest = database.execAndGet("PRAGMA journal_mode").getString() != "wal";
  if (at_rest && ::stat(path.c_str(), &status) == 0 && status.st_size % pragma(database, "page_size") != 0) {
    return tl::unexpected(damaged(path, "it is cut short"));
  }
  return {};
}

void bring_up_to_date(SQLite::Database& database) {
  if (pragma(database, "user_version") == kSchemaVersion) {
    return;
  }
  SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
  if (pragma(database, "user_version") < kProblemVersion) {  // nobody was quicker
    database.exec("ALTER TABLE study ADD COLUMN problem TEXT NOT NULL DEFAULT ''");
  }
  database.exec(fmt::format("PRAGMA user_version = {}", kSchemaVersion));
  transaction.commit();
}

}  // namespace

bool has_problem(SQLite::Database& database) { return pragma(database, "user_version") >= kProblemVersion; }

Error error_of(const std::string& path, const SQLite::Exception& exception) {
  const char* detail = exception.what();
  switch (exception.getErrorCode()) {
    case SQLITE_NOTADB:
      return not_a_study(path, "not an SQLite database").value();
    case SQLITE_CORRUPT:
      return damaged(path, detail);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorKind::failed,
              fmt::format("{}: another process has been writing to it for {} s: try again when it is "
                          "done",
                          path, std::chrono::duration<double>(kBusyTimeout).count())};
    case SQLITE_FULL:
      return {ErrorKind::failed, fmt::format("{}: cannot be written: the disk is full, or a limit on file size is "
                                             "reached",
                                             path)};
    case SQLITE_READONLY:
      return {ErrorKind::failed, fmt::format("{}: cannot be written: {}", path, detail)};
    case SQLITE_TOOBIG:
      return {ErrorKind::failed, fmt::format("{}: too large for an SQLite database: {}", path, detail)};
    default:
      return {ErrorKind::failed,
              fmt::format("{}: {} (SQLite error {})", path, detail, exception.getExtendedErrorCode())};
  }
}

Error damaged(const std::string& path, const std::string& what) {
  return {ErrorKind::damaged, fmt::format("{}: damaged: {}", path, what)};
}

SQLite::Database create_database(const std::string& path) {
  SQLite::Database database(path, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  database.exec("PRAGMA journal_mode = OFF");
  database.exec("PRAGMA synchronous = OFF");
  database.exec(fmt::format("PRAGMA application_id = {}", kApplicationId));
  database.exec(fmt::format("PRAGMA user_version = {}", kSchemaVersion));
  database.exec(kSchema);
  return database;
}

Result<SQLite::Database> open_database(const std::string& path, bool write) {
  if (auto ok = check_file(path, write); !ok) {
    return tl::unexpected(ok.error());
  }
  SQLite::Database database(path, write ? SQLite::OPEN_READWRITE : SQLite::OPEN_READONLY, busy_timeout_ms());
  if (pragma(database, "application_id") != kApplicationId) {
    return not_a_study(path, "an SQLite database of some other program");
  }
  if (const int version = pragma(database, "user_version"); version < kOldestVersion || version > kSchemaVersion) {
    return bad_input(fmt::format("{}: a study of schema version {}: this program knows version {}{}", path, version,
                                 kSchemaVersion, version > kSchemaVersion ? " and is too old for it" : ""));
  }
  if (auto ok = check_length(path, database); !ok) {
    return tl::unexpected(ok.error());
  }
  const std::string verdict = database.execAndGet("PRAGMA quick_check(1)").getString();
  if (verdict != "ok") {
    return tl::unexpected(damaged(path, verdict));
  }
  database.exec("PRAGMA foreign_keys = ON");
  if (write) {
    // A commit to the write-ahead log needs no fsync with NORMAL and survives the death of the process. Where there
    // can be no such log (some network file systems), commits are slower and as safe.
    const std::string mode = database.execAndGet("PRAGMA journal_mode = WAL").getString();
    database.exec(mode == "wal" ? "PRAGMA synchronous = NORMAL" : "PRAGMA synchronous = FULL");
    bring_up_to_date(database);
  }
  return database;
}

void settle(SQLite::Database& database) noexcept {
  try {
    database.setBusyTimeout(0);
    database.exec("PRAGMA journal_mode = DELETE");
  } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch)
    // Another process has it open and will do this when it leaves; nothing is lost.
  }
}

}  // namespace coppice
