// The SQLite side of a study: its schema, how a connection is opened, and what a failure of SQLite says to a user.
// Exceptions of the wrapper library end here.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <string>
#include <utility>

#include "common/error.hpp"

namespace coppice {

// Names the file, what went wrong and, where there is something to do, what. Foreign or damaged: bad_input.
Error error_of(const std::string& path, const SQLite::Exception& exception);

// What a file that is not as its writer left it gets.
Error damaged(const std::string& path, const std::string& what);

// f() with SQLite's exceptions as errors that name the file. f returns a Result.
template <typename F>
auto guarded(const std::string& path, F&& f) -> decltype(f()) {
  try {
    return std::forward<F>(f)();
  } catch (const SQLite::Exception& exception) {
    return tl::unexpected(error_of(path, exception));
  }
}

// An empty study in a new file: tables, application id, schema version. Writes to it are quick and safe against
// nothing: it is for a file that counts only once it is complete and synced. Throws SQLite::Exception.
SQLite::Database create_database(const std::string& path);

// Opens what create_database() made, or an older program's; the latter is brought up to date when it is opened to
// write. Errors: as Study::open(), the content of the tables aside. May throw SQLite::Exception.
Result<SQLite::Database> open_database(const std::string& path, bool write);

// False: read from a file of a schema before problems were kept.
bool has_problem(SQLite::Database& database);

// Back to a single file, if no other process has it open. Never throws.
void settle(SQLite::Database& database) noexcept;

}  // namespace coppice
