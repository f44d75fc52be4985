// How each deme of a run went, generation by generation. The table is made with the first rows, so that programs that
// know nothing of it read the study as before.
#include "coordinator/study/study_demes.hpp"

#include <fmt/format.h>

#include "coordinator/study/database.hpp"
#include "coordinator/study/study_rows.hpp"
#include "coordinator/study/study_state.hpp"

namespace coppice {
namespace {

constexpr const char* kDemeTable = R"(
CREATE TABLE IF NOT EXISTS deme_generations(
  run          INTEGER NOT NULL REFERENCES runs(id),
  generation   INTEGER NOT NULL,    -- from 0
  deme         INTEGER NOT NULL,    -- from 0
  best_fitness REAL NOT NULL,
  best_nodes   INTEGER NOT NULL,
  mean_fitness REAL NOT NULL,
  mean_nodes   REAL NOT NULL,
  evaluations  INTEGER NOT NULL,    -- in this generation
  PRIMARY KEY(run, generation, deme)
) STRICT;
)";

bool has_deme_table(SQLite::Database& database) { return database.tableExists("deme_generations"); }

}  // namespace

DemeGeneration in_short(const GenerationRecord& record) {
  return {.best_fitness = record.best.fitness,
          .mean_fitness = record.mean_fitness,
          .best_nodes = static_cast<std::uint32_t>(record.best_nodes()),
          .mean_nodes = record.mean_nodes,
          .evaluations = record.evaluations};
}

void insert_demes(SQLite::Database& database, RunId run, std::span<const std::vector<GenerationRecord>> of_demes) {
  database.exec(kDemeTable);
  SQLite::Statement row(database, "INSERT INTO deme_generations VALUES(?, ?, ?, ?, ?, ?, ?, ?)");
  for (std::size_t deme = 0; deme < of_demes.size(); ++deme) {
    for (const GenerationRecord& record : of_demes[deme]) {
      const DemeGeneration kept = in_short(record);
      row.bind(1, number(run));
      row.bind(2, record.generation);
      row.bind(3, static_cast<std::int64_t>(deme));
      row.bind(4, kept.best_fitness);
      row.bind(5, kept.best_nodes);
      row.bind(6, kept.mean_fitness);
      row.bind(7, kept.mean_nodes);
      row.bind(8, static_cast<std::int64_t>(kept.evaluations));
      row.exec();
      row.reset();
    }
  }
}

void forget_demes(SQLite::Database& database, RunId run, std::uint32_t from) {
  if (has_deme_table(database)) {
    SQLite::Statement forget(database, "DELETE FROM deme_generations WHERE run = ? AND generation >= ?");
    forget.bind(1, number(run));
    forget.bind(2, from);
    forget.exec();
  }
}

Result<DemeGenerations> Study::deme_generations(RunId run) const {
  return guarded(state_->path, [&]() -> Result<DemeGenerations> {
    DemeGenerations kept;
    if (!has_deme_table(state_->database)) {
      return kept;
    }
    SQLite::Statement select(state_->database,
                             "SELECT generation, deme, best_fitness, mean_fitness, best_nodes, mean_nodes, evaluations "
                             "FROM deme_generations WHERE run = ? ORDER BY generation, deme");
    select.bind(1, number(run));
    while (select.executeStep()) {
      const std::uint32_t generation = select.getColumn(0).getUInt();
      const std::uint32_t deme = select.getColumn(1).getUInt();
      if (kept.generation.empty() || kept.generation.back() != generation) {
        kept.generation.push_back(generation);
      }
      if (kept.generation.size() == 1 && deme == kept.demes.size()) {
        kept.demes.emplace_back();
      }
      if (deme >= kept.demes.size() || kept.demes[deme].size() + 1 != kept.generation.size()) {
        return tl::unexpected(
            damaged(state_->path, fmt::format("{}, generation {}: deme {} is missing", label(run), generation, deme)));
      }
      kept.demes[deme].push_back({.best_fitness = select.getColumn(2).getDouble(),
                                  .mean_fitness = select.getColumn(3).getDouble(),
                                  .best_nodes = select.getColumn(4).getUInt(),
                                  .mean_nodes = select.getColumn(5).getDouble(),
                                  .evaluations = static_cast<std::uint64_t>(select.getColumn(6).getInt64())});
    }
    for (const auto& deme : kept.demes) {
      if (deme.size() != kept.generation.size()) {
        return tl::unexpected(
            damaged(state_->path, fmt::format("{}: a deme's last generations are missing", label(run))));
      }
    }
    return kept;
  });
}

}  // namespace coppice
