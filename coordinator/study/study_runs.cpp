// The runs of a study: their rows, statistics and checkpoints.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/check.hpp"
#include "common/tree/text.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/study/checkpoint_text.hpp"
#include "coordinator/study/database.hpp"
#include "coordinator/study/study_demes.hpp"
#include "coordinator/study/study_rows.hpp"
#include "coordinator/study/study_state.hpp"

namespace coppice {
namespace {

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
  const std::string archive = archives_text({checkpoint.archive, checkpoint.kept}, vocabulary);
  SQLite::Statement replace(database, "INSERT OR REPLACE INTO checkpoints VALUES(?, ?, ?, ?, ?)");
  replace.bind(1, number(run));
  replace.bind(2, checkpoint.generation);
  replace.bind(3, population);
  replace.bind(4, archive);
  replace.bind(5, hash_hex(population + archive));
  replace.exec();
}

}  // namespace

Result<RunId> Study::begin_run(const NewRun& run) {
  return guarded(state_->path, [&]() -> Result<RunId> {
    SQLite::Transaction transaction(state_->database, SQLite::TransactionBehavior::IMMEDIATE);
    StudyRows rows(state_->path, chain().vocabulary(), state_->database);
    const auto running = rows.runs("WHERE status = 'running'");
    if (!running) {
      return tl::unexpected(running.error());
    }
    const Owner here = this_process();
    for (const OwnedRun& other : *running) {
      if (other.owner != here && state_of(other.owner) == OwnerState::alive) {
        return bad_input(
            fmt::format("{}: {} is being run by process {}: wait for its end, or evolve in a copy (coppice "
                        "backup)",
                        state_->path, label(other.record.id), other.owner.pid));
      }
    }
    SQLite::Statement insert(state_->database,
                             "INSERT INTO runs(seed, config, evaluator, status, started, owner_host, owner_boot, "
                             "owner_space, owner_pid, owner_start) "
                             "VALUES(?, ?, ?, 'running', strftime('%Y-%m-%dT%H:%M:%SZ', 'now'), ?, ?, ?, ?, ?)");
    insert.bind(1, fmt::format("{}", run.config.seed));
    insert.bind(2, config_to_json(run.config));
    insert.bind(3, run.evaluator);
    bind_owner(insert, 4, this_process());
    insert.exec();
    const RunId id{state_->database.getLastInsertRowid()};
    transaction.commit();
    return id;
  });
}

Result<ResumedRun> Study::resume_run(RunId run, bool take_over) {
  return guarded(state_->path, [&]() -> Result<ResumedRun> {
    SQLite::Transaction transaction(state_->database, SQLite::TransactionBehavior::IMMEDIATE);
    StudyRows rows(state_->path, chain().vocabulary(), state_->database);
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

Result<void> Study::save_generations(RunId run, std::span<const GenerationRecord> records, const Checkpoint& checkpoint,
                                     std::span<const std::vector<GenerationRecord>> of_demes) {
  COPPICE_CHECK(!records.empty() && records.back().generation == checkpoint.generation);
  const Vocabulary& vocabulary = chain().vocabulary();
  return guarded(state_->path, [&]() -> Result<void> {
    SQLite::Transaction transaction(state_->database, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement row(state_->database, "INSERT INTO generations VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    for (const GenerationRecord& record : records) {
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
      row.reset();
    }
    if (!of_demes.empty()) {
      insert_demes(state_->database, run, of_demes);
    }
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
    forget_demes(state_->database, run, to ? to->generation + 1 : 0);
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
    auto found = StudyRows(state_->path, chain().vocabulary(), state_->database).runs("ORDER BY id");
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
    auto found = StudyRows(state_->path, chain().vocabulary(), state_->database).run(run);
    return found ? Result<RunRecord>(std::move(found->record)) : tl::unexpected(found.error());
  });
}

Result<std::optional<RunRecord>> Study::last_run() const {
  return guarded(state_->path, [&]() -> Result<std::optional<RunRecord>> {
    auto found = StudyRows(state_->path, chain().vocabulary(), state_->database).runs("ORDER BY id DESC LIMIT 1");
    if (!found) {
      return tl::unexpected(found.error());
    }
    return found->empty() ? std::optional<RunRecord>() : std::optional(std::move(found->front().record));
  });
}

Result<std::vector<GenerationRecord>> Study::generations(RunId run) const {
  return guarded(state_->path,
                 [&] { return StudyRows(state_->path, chain().vocabulary(), state_->database).generations(run); });
}

Result<std::optional<Checkpoint>> Study::load_checkpoint(RunId run) const {
  return guarded(state_->path,
                 [&] { return StudyRows(state_->path, chain().vocabulary(), state_->database).checkpoint(run); });
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
