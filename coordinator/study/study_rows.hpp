// What the tables of runs hold, as values. Messages about what cannot be read name the file and the row. Private to
// study*.cpp.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/study/owner.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

std::int64_t number(RunId run);
std::string label(RunId run);                   // "run 3"
std::string hash_hex(const std::string& text);  // of a checkpoint's text, to notice damage

// A row of `runs` with what decides about taking it over.
struct OwnedRun {
  RunRecord record;
  Owner owner;
};

class StudyRows {
 public:
  StudyRows(const std::string& path, const Vocabulary& vocabulary, SQLite::Database& database)
      : path_(path), vocabulary_(vocabulary), database_(database) {}

  // `condition`: SQL behind the table's name.
  Result<std::vector<OwnedRun>> runs(const std::string& condition);
  // Errors: no such run, too.
  Result<OwnedRun> run(RunId id);
  Result<std::vector<GenerationRecord>> generations(RunId run);
  Result<std::optional<Checkpoint>> checkpoint(RunId run);

 private:
  tl::unexpected<Error> damage(const std::string& what) const;
  Result<OwnedRun> run_of(SQLite::Statement& row);

  const std::string& path_;
  const Vocabulary& vocabulary_;
  SQLite::Database& database_;
};

}  // namespace coppice
