// Writes and forgets rows of deme_generations, inside the caller's transaction. Private to study*.cpp.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <cstdint>
#include <span>
#include <vector>

#include "coordinator/study/study.hpp"

namespace coppice {

// [demes][generations] They throw as SQLiteCpp does.
void insert_demes(SQLite::Database& database, RunId run, std::span<const std::vector<GenerationRecord>> of_demes);
// Those of generation `from` and all after it.
void forget_demes(SQLite::Database& database, RunId run, std::uint32_t from);

}  // namespace coppice
