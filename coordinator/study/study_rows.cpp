#include "coordinator/study/study_rows.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <string_view>

#include "common/tree/text.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/study/checkpoint_text.hpp"
#include "coordinator/study/database.hpp"

namespace coppice {
namespace {

constexpr const char* kRunColumns =
    "SELECT id, config, evaluator, status, started, coalesce(ended, ''), tree, pruned, result, owner_host, owner_boot, "
    "owner_space, owner_pid, owner_start, (SELECT count(*) FROM generations WHERE run = runs.id) FROM runs ";

}  // namespace

std::int64_t number(RunId run) { return static_cast<std::int64_t>(run); }

std::string label(RunId run) { return fmt::format("run {}", number(run)); }

std::string hash_hex(const std::string& text) {
  return hash_of({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}).hex();
}

tl::unexpected<Error> StudyRows::damage(const std::string& what) const { return tl::unexpected(damaged(path_, what)); }

Result<std::vector<OwnedRun>> StudyRows::runs(const std::string& condition) {
  SQLite::Statement select(database_, kRunColumns + condition);
  std::vector<OwnedRun> runs;
  while (select.executeStep()) {
    auto run = run_of(select);
    if (!run) {
      return tl::unexpected(run.error());
    }
    runs.push_back(std::move(*run));
  }
  return runs;
}

Result<OwnedRun> StudyRows::run(RunId id) {
  auto found = runs(fmt::format("WHERE id = {}", number(id)));
  if (!found) {
    return tl::unexpected(found.error());
  }
  if (found->empty()) {
    const int count = database_.execAndGet("SELECT count(*) FROM runs").getInt();
    return bad_input(count == 0 ? fmt::format("{}: no {}: it holds no runs yet", path_, label(id))
                                : fmt::format("{}: no {}: expected 1 to {}", path_, label(id), count));
  }
  return std::move(found->front());
}

Result<std::vector<GenerationRecord>> StudyRows::generations(RunId run) {
  SQLite::Statement select(database_,
                           "SELECT generation, best_tree, best_fitness, best_agreement, mean_fitness, mean_agreement, "
                           "mean_nodes, distinct_trees, evaluations, seconds FROM generations WHERE run = ? "
                           "ORDER BY generation");
  select.bind(1, number(run));
  std::vector<GenerationRecord> records;
  while (select.executeStep()) {
    const std::uint32_t generation = select.getColumn(0).getUInt();
    auto tree = parse_tree(select.getColumn(1).getString(), vocabulary_);
    if (!tree || generation != records.size()) {
      return damage(fmt::format("{}, generation {}: {}", label(run), records.size(),
                                tree ? std::string("missing") : tree.error().message));
    }
    records.push_back(
        {.generation = generation,
         .best = {std::move(*tree), generation, select.getColumn(2).getDouble(), select.getColumn(3).getDouble()},
         .mean_fitness = select.getColumn(4).getDouble(),
         .mean_agreement = select.getColumn(5).getDouble(),
         .mean_nodes = select.getColumn(6).getDouble(),
         .distinct_trees = select.getColumn(7).getUInt(),
         .evaluations = static_cast<std::uint64_t>(select.getColumn(8).getInt64()),
         .seconds = select.getColumn(9).getDouble()});
  }
  return records;
}

Result<std::optional<Checkpoint>> StudyRows::checkpoint(RunId run) {
  SQLite::Statement select(database_, "SELECT generation, population, hash, archive FROM checkpoints WHERE run = ?");
  select.bind(1, number(run));
  if (!select.executeStep()) {
    return std::optional<Checkpoint>();
  }
  const std::string text = select.getColumn(1).getString();
  const std::string archive_text = select.getColumn(3).getString();
  if (hash_hex(text + archive_text) != select.getColumn(2).getString()) {
    return damage(fmt::format("{}: the checkpoint does not match its hash", label(run)));
  }
  auto population = population_from_text(text, vocabulary_);
  if (!population) {
    return damage(fmt::format("{}: checkpoint: {}", label(run), population.error().message));
  }
  auto archive = archives_from_text(archive_text, vocabulary_);
  if (!archive) {
    return damage(fmt::format("{}: archive of the checkpoint: {}", label(run), archive.error().message));
  }
  Checkpoint checkpoint{select.getColumn(0).getUInt(), std::move(population->trees), std::move(population->fitness), {},
                        std::move(archive->trees),     std::move(archive->kept)};
  const auto records = generations(run);
  if (!records) {
    return tl::unexpected(records.error());
  }
  if (records->size() <= checkpoint.generation) {
    return damage(fmt::format("{}: statistics of {} generations with a checkpoint of generation {}", label(run),
                              records->size(), checkpoint.generation));
  }
  for (std::uint32_t generation = 0; generation <= checkpoint.generation; ++generation) {
    enter((*records)[generation].best, checkpoint.hall_of_fame);
  }
  return std::optional(std::move(checkpoint));
}

Result<OwnedRun> StudyRows::run_of(SQLite::Statement& row) {
  OwnedRun run;
  RunRecord& record = run.record;
  record.id = RunId{row.getColumn(0).getInt64()};
  const auto in_run = [&](const Error& error) { return damage(label(record.id) + ": " + error.message); };
  auto config = config_from_json(row.getColumn(1).getString());
  if (!config) {
    return in_run(config.error());
  }
  record.config = std::move(*config);
  record.evaluator = row.getColumn(2).getString();
  const auto status = value_named<RunStatus>("status", row.getColumn(3).getString());
  if (!status) {
    return in_run(status.error());
  }
  record.status = *status;
  record.started = row.getColumn(4).getString();
  record.ended = row.getColumn(5).getString();
  for (auto [column, tree] : {std::pair{6, &record.tree}, std::pair{7, &record.pruned}}) {
    if (!row.isColumnNull(column)) {
      auto parsed = parse_tree(row.getColumn(column).getString(), vocabulary_);
      if (!parsed) {
        return in_run(parsed.error());
      }
      *tree = std::move(*parsed);
    }
  }
  record.json = row.getColumn(8).getString();
  run.owner = {row.getColumn(9).getString(), row.getColumn(10).getString(), row.getColumn(11).getString(),
               row.getColumn(12).getInt64(), row.getColumn(13).getString()};
  record.generations = row.getColumn(14).getUInt();
  record.abandoned = record.status == RunStatus::running && state_of(run.owner) == OwnerState::gone;
  return run;
}

}  // namespace coppice
