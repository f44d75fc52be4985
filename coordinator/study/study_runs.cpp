// The runs of a study: their rows, statistics and checkpoints.
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/check.hpp"
#include "common/tree/text.hpp"
#include "coordinator/study/checkpoint_text.hpp"
#include "coordinator/study/database.hpp"
#include "coordinator/study/owner.hpp"
#include "coordinator/study/study_state.hpp"

namespace coppice {
namespace {

constexpr std::array<std::string_view, 4> kStatusNames = {"running", "finished", "interrupted", "failed"};

constexpr const char* kRunColumns =
    "SELECT id, config, evaluator, status, started, coalesce(ended, ''), tree, pruned, result, owner_host, owner_boot, "
    "owner_space, owner_pid, owner_start, (SELECT count(*) FROM generations WHERE run = runs.id) FROM runs ";

std::int64_t number(RunId run) { return static_cast<std::int64_t>(run); }

std::string label(RunId run) { return fmt::format("run {}", number(run)); }

std::string hash_hex(const std::string& text) {
  return hash_of({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}).hex();
}

void bind(SQLite::Statement& statement, int index, const std::optional<Tree>& tree, const Vocabulary& vocabulary) {
  if (tree) {
    statement.bind(index, to_text(*tree, vocabulary));
  } else {
    statement.bind(index);
  }
}

void bind_owner(SQLite::Statement& statement, int index, const Owner& owner) {
  statement.bind(index, owner.host);
  statement.bind(index + 1, owner.boot);
  statement.bind(index + 2, owner.space);
  statement.bind(index + 3, owner.pid);
  statement.bind(index + 4, owner.start);
}

// A row of `runs` with what decides about taking it over.
struct OwnedRun {
  RunRecord record;
  Owner owner;
};

// Rows of a study's tables, as values. Messages about what cannot be read name the file and the row.
class Rows {
 public:
  Rows(const std::string& path, const Vocabulary& vocabulary, SQLite::Database& database)
      : path_(path), vocabulary_(vocabulary), database_(database) {}

  Result<std::vector<OwnedRun>> runs(const std::string& condition) {
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

  Result<OwnedRun> run(RunId id) {
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

  Result<std::vector<GenerationRecord>> generations(RunId run) {
    SQLite::Statement select(
        database_,
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

  Result<std::optional<Checkpoint>> checkpoint(RunId run) {
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
    auto archive = population_from_text(archive_text, vocabulary_);
    if (!archive) {
      return damage(fmt::format("{}: archive of the checkpoint: {}", label(run), archive.error().message));
    }
    Checkpoint checkpoint{select.getColumn(0).getUInt(),
                          std::move(population->trees),
                          std::move(population->fitness),
                          {},
                          std::move(archive->trees)};
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

 private:
  tl::unexpected<Error> damage(const std::string& what) const { return tl::unexpected(damaged(path_, what)); }

  Result<OwnedRun> run_of(SQLite::Statement& row) {
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
    const auto status = std::find(kStatusNames.begin(), kStatusNames.end(), row.getColumn(3).getString());
    if (status == kStatusNames.end()) {
      return in_run({ErrorKind::bad_input, "unknown status"});
    }
    record.status = static_cast<RunStatus>(status - kStatusNames.begin());
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

  const std::string& path_;
  const Vocabulary& vocabulary_;
  SQLite::Database& database_;
};

Result<void> check_free(const std::string& path, const OwnedRun& run, bool take_over) {
  const std::string name = label(run.record.id);
  if (run.record.status == RunStatus::finished) {
    return bad_input(fmt::format("{}: {} is finished: expected one that is not", path, name));
  }
  if (run.record.status != RunStatus::running) {
    return {};
  }
  switch (state_of(run.owner)) {
    case OwnerState::gone:
      return {};
    case OwnerState::alive:
      return bad_input(fmt::format("{}: {} is being run by process {}: stop it first", path, name, run.owner.pid));
    case OwnerState::unknown:
      break;
  }
  if (take_over) {
    return {};
  }
  return bad_input(
      fmt::format("{}: {} belongs to process {} on {}, which cannot be seen from here: make sure that it "
                  "has ended",
                  path, name, run.owner.pid, run.owner.host));
}

void replace_checkpoint(SQLite::Database& database, RunId run, const Checkpoint& checkpoint,
                        const Vocabulary& vocabulary) {
  const std::string population = population_text({checkpoint.population, checkpoint.fitness}, vocabulary);
  const std::string archive =
      population_text({checkpoint.archive, std::vector<double>(checkpoint.archive.size(), 0.0)}, vocabulary);
  SQLite::Statement replace(database, "INSERT OR REPLACE INTO checkpoints VALUES(?, ?, ?, ?, ?)");
  replace.bind(1, number(run));
  replace.bind(2, checkpoint.generation);
  replace.bind(3, population);
  replace.bind(4, archive);
  replace.bind(5, hash_hex(population + archive));
  replace.exec();
}

}  // namespace

std::string_view name_of(RunStatus status) { return kStatusNames.at(static_cast<std::size_t>(status)); }

Result<RunId> Study::begin_run(const NewRun& run) {
  return guarded(state_->path, [&]() -> Result<RunId> {
    SQLite::Statement insert(state_->database,
                             "INSERT INTO runs(seed, config, evaluator, status, started, owner_host, owner_boot, "
                             "owner_space, owner_pid, owner_start) "
                             "VALUES(?, ?, ?, 'running', strftime('%Y-%m-%dT%H:%M:%SZ', 'now'), ?, ?, ?, ?, ?)");
    insert.bind(1, fmt::format("{}", run.config.seed));
    insert.bind(2, config_to_json(run.config));
    insert.bind(3, run.evaluator);
    bind_owner(insert, 4, this_process());
    insert.exec();
    return RunId{state_->database.getLastInsertRowid()};
  });
}

Result<ResumedRun> Study::resume_run(RunId run, bool take_over) {
  return guarded(state_->path, [&]() -> Result<ResumedRun> {
    SQLite::Transaction transaction(state_->database, SQLite::TransactionBehavior::IMMEDIATE);
    Rows rows(state_->path, chain().vocabulary(), state_->database);
    auto found = rows.run(run);
    if (!found) {
      return tl::unexpected(found.error());
    }
    if (auto ok = check_free(state_->path, *found, take_over); !ok) {
      return tl::unexpected(ok.error());
    }
    auto checkpoint = rows.checkpoint(run);
    if (!checkpoint) {
      return tl::unexpected(checkpoint.error());
    }
    SQLite::Statement update(state_->database,
                             "UPDATE runs SET status = 'running', ended = NULL, tree = NULL, pruned = NULL, result = "
                             "'{}', owner_host = ?, owner_boot = ?, owner_space = ?, owner_pid = ?, owner_start = ? "
                             "WHERE id = ?");
    bind_owner(update, 1, this_process());
    update.bind(6, number(run));
    update.exec();
    transaction.commit();
    return ResumedRun{std::move(found->record.config), std::move(*checkpoint)};
  });
}

Result<void> Study::save_generation(RunId run, const GenerationRecord& record, const Checkpoint& checkpoint) {
  COPPICE_CHECK(record.generation == checkpoint.generation);
  const Vocabulary& vocabulary = chain().vocabulary();
  return guarded(state_->path, [&]() -> Result<void> {
    SQLite::Transaction transaction(state_->database, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement row(state_->database, "INSERT INTO generations VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    row.bind(1, number(run));
    row.bind(2, record.generation);
    row.bind(3, to_text(record.best.tree, vocabulary));
    row.bind(4, record.best.fitness);
    row.bind(5, record.best.agreement);
    row.bind(6, static_cast<std::int64_t>(record.best_nodes()));
    row.bind(7, record.mean_fitness);
    row.bind(8, record.mean_agreement);
    row.bind(9, record.mean_nodes);
    row.bind(10, record.distinct_trees);
    row.bind(11, static_cast<std::int64_t>(record.evaluations));
    row.bind(12, record.seconds);
    row.exec();
    replace_checkpoint(state_->database, run, checkpoint, vocabulary);
    transaction.commit();
    return state_->check_in_place();
  });
}

Result<void> Study::rewind_run(RunId run, const std::optional<Checkpoint>& to) {
  return guarded(state_->path, [&]() -> Result<void> {
    SQLite::Transaction transaction(state_->database, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement forget(state_->database, "DELETE FROM generations WHERE run = ? AND generation >= ?");
    forget.bind(1, number(run));
    forget.bind(2, to ? to->generation + 1 : 0);
    forget.exec();
    if (to) {
      replace_checkpoint(state_->database, run, *to, chain().vocabulary());
    } else {
      SQLite::Statement remove(state_->database, "DELETE FROM checkpoints WHERE run = ?");
      remove.bind(1, number(run));
      remove.exec();
    }
    transaction.commit();
    return state_->check_in_place();
  });
}

Result<void> Study::finish_run(RunId run, const RunOutcome& outcome) {
  COPPICE_CHECK(outcome.status != RunStatus::running);
  COPPICE_CHECK(nlohmann::json::parse(outcome.json, nullptr, false).is_object());
  return guarded(state_->path, [&]() -> Result<void> {
    SQLite::Statement update(state_->database,
                             "UPDATE runs SET status = ?, ended = strftime('%Y-%m-%dT%H:%M:%SZ', 'now'), tree = ?, "
                             "pruned = ?, result = ? WHERE id = ?");
    update.bind(1, std::string(name_of(outcome.status)));
    bind(update, 2, outcome.tree, chain().vocabulary());
    bind(update, 3, outcome.pruned, chain().vocabulary());
    update.bind(4, outcome.json);
    update.bind(5, number(run));
    COPPICE_CHECK(update.exec() == 1);
    return state_->check_in_place();
  });
}

Result<std::vector<RunRecord>> Study::runs() const {
  return guarded(state_->path, [&]() -> Result<std::vector<RunRecord>> {
    auto found = Rows(state_->path, chain().vocabulary(), state_->database).runs("ORDER BY id");
    if (!found) {
      return tl::unexpected(found.error());
    }
    std::vector<RunRecord> records;
    for (OwnedRun& run : *found) {
      records.push_back(std::move(run.record));
    }
    return records;
  });
}

Result<RunRecord> Study::run(RunId run) const {
  return guarded(state_->path, [&]() -> Result<RunRecord> {
    auto found = Rows(state_->path, chain().vocabulary(), state_->database).run(run);
    return found ? Result<RunRecord>(std::move(found->record)) : tl::unexpected(found.error());
  });
}

Result<std::optional<RunRecord>> Study::last_run() const {
  return guarded(state_->path, [&]() -> Result<std::optional<RunRecord>> {
    auto found = Rows(state_->path, chain().vocabulary(), state_->database).runs("ORDER BY id DESC LIMIT 1");
    if (!found) {
      return tl::unexpected(found.error());
    }
    return found->empty() ? std::optional<RunRecord>() : std::optional(std::move(found->front().record));
  });
}

Result<std::vector<GenerationRecord>> Study::generations(RunId run) const {
  return guarded(state_->path,
                 [&] { return Rows(state_->path, chain().vocabulary(), state_->database).generations(run); });
}

Result<std::optional<Checkpoint>> Study::load_checkpoint(RunId run) const {
  return guarded(state_->path,
                 [&] { return Rows(state_->path, chain().vocabulary(), state_->database).checkpoint(run); });
}

Result<Tree> Study::best_tree(RunId id) const {
  auto record = run(id);
  if (!record) {
    return tl::unexpected(record.error());
  }
  if (record->tree) {
    return std::move(*record->tree);
  }
  const auto records = generations(id);
  if (!records) {
    return tl::unexpected(records.error());
  }
  HallOfFame hall;
  for (const GenerationRecord& generation : *records) {
    enter(generation.best, hall);
  }
  if (hall.empty()) {
    return bad_input(fmt::format("{}: {} has not one generation yet: expected one or more", path(), label(id)));
  }
  return best_on_record(hall).tree;
}

}  // namespace coppice
