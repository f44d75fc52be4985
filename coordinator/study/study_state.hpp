// What an open Study owns. Private to study.cpp and study_runs.cpp.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <string>

#include "coordinator/study/study.hpp"

namespace coppice {

struct Study::State {
  std::string path;
  Access access = Access::read;
  mutable SQLite::Database database;
  Chain chain;
  ChainHash chain_hash;
  StudyWorld world;
  StudyLearning learning;
};

}  // namespace coppice
