// What an open Study owns. Private to study*.cpp.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <string>
#include <sys/types.h>

#include "coordinator/study/study.hpp"

namespace coppice {

struct FileId {
  dev_t device = 0;
  ino_t inode = 0;
  bool operator==(const FileId&) const = default;
};

struct Study::State {
  std::string path;
  Access access = Access::read;
  mutable SQLite::Database database;
  Chain chain;
  ChainHash chain_hash;
  StudyWorld world;
  StudyLearning learning;
  Problem problem;
  FileId file;  // of the open file

  // Error: the path leads elsewhere by now, or nowhere: what is written would be lost with the open file.
  Result<void> check_in_place() const;
};

}  // namespace coppice
