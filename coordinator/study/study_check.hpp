// Looks through everything that a study holds: what is damaged, and what of it can still be used.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

struct CheckedRun {
  std::int64_t run = 0;
  std::string status;
  std::uint32_t generations = 0;    // that can be read
  bool resumable = false;           // unfinished, with a checkpoint that can be read or before its first generation
  std::vector<std::string> damage;  // empty: all of it can be read
};

struct StudyCheck {
  std::vector<std::string> damage;  // of the file and of what runs share; empty: none
  std::vector<CheckedRun> runs;     // as far as they could be listed
  // Where anything is damaged: the text of the answers of runs and of their 20 best champions.
  std::vector<std::string> trees;

  bool whole() const;
};

// Reads all: the file's pages and indices (SQLite's integrity check), the chain against its hash, each run's
// configuration, generations, checkpoint, front and trees. Writes nothing. Errors: there is nothing that could be
// looked at (no file, no study, no right to read it).
Result<StudyCheck> check_study(const std::string& path);

}  // namespace coppice
