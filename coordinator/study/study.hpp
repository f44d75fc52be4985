// A study: one SQLite file that holds a chain, the world and the settings that it was learned with, and every run of
// evolution on it with statistics and a checkpoint for each generation. A Study owns the open file. Invariant:
// whatever the file holds was complete when it was written: it appears under its name finished, and each generation
// comes in one transaction, so kill -9 or a crash loses at most the generation under way (a power cut: the
// last few). One thread at a time; several processes may have the same file open.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/chain/chain_bytes.hpp"
#include "common/error.hpp"
#include "common/named.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {

inline constexpr std::chrono::milliseconds kBusyTimeout{10'000};  // how long to wait while another process writes

enum class RunId : std::int64_t {};  // from 1, in order of start

enum class RunStatus : std::uint8_t { running, finished, interrupted, failed };
template <>
inline constexpr std::array kNames<RunStatus> = names("running", "finished", "interrupted", "failed");

// What make_world() takes (coordinator/learning/world.hpp).
struct StudyWorld {
  std::string kind;
  std::string room;
  bool operator==(const StudyWorld&) const = default;
};

// How the chain came about: two JSON objects, kept as they are given.
struct StudyLearning {
  std::string settings = "{}";
  std::string outcome = "{}";
  bool operator==(const StudyLearning&) const = default;
};

struct NewRun {
  EvolveConfig config;
  std::string evaluator;  // in words: "serial", "2 local workers"
};

// What a run ended with.
struct RunOutcome {
  RunStatus status = RunStatus::finished;  // not running
  std::optional<Tree> tree;                // as evolved
  std::optional<Tree> pruned;
  std::string json = "{}";  // anything else worth keeping: a JSON object
};

struct RunRecord {
  RunId id{};
  EvolveConfig config;
  std::string evaluator;
  RunStatus status = RunStatus::running;
  bool abandoned = false;         // running, but the process that ran it is gone: it can be resumed
  std::string started;            // UTC, 2016-11-09T12:34:56Z
  std::string ended;              // empty while running
  std::uint32_t generations = 0;  // saved
  std::optional<Tree> tree;
  std::optional<Tree> pruned;
  std::string json = "{}";
};

struct ResumedRun {
  EvolveConfig config;
  std::optional<Checkpoint> checkpoint;  // none: not one generation was saved, start from the first
};

// One generation of one deme, as curves show it.
struct DemeGeneration {
  double best_fitness = 0.0;
  double mean_fitness = 0.0;
  std::uint32_t best_nodes = 0;  // of the tree of the best fitness
  double mean_nodes = 0.0;
  std::uint64_t evaluations = 0;  // individuals evaluated in this generation
  bool operator==(const DemeGeneration&) const = default;
};
DemeGeneration in_short(const GenerationRecord& record);

// All of a run that were kept.
struct DemeGenerations {
  std::vector<std::uint32_t> generation;           // ascending
  std::vector<std::vector<DemeGeneration>> demes;  // [demes][generations]
};

// A tree that a person keeps, as the studio does.
inline constexpr std::size_t kMaxKeptName = 200;     // bytes
inline constexpr std::size_t kMaxKeptNote = 20'000;  // bytes
struct KeptTree {
  std::int64_t id = 0;
  std::string name;
  std::string note;
  Tree tree;
  std::string kept;  // UTC, when
};

class Study {
 public:
  enum class Access : std::uint8_t { read, write };

  // Makes a new file; under `path` it appears only when it is complete. Errors: path exists (bad_input), a folder
  // that does not exist or cannot be written, a full disk, learning that is not JSON.
  // Without a problem it is that of the world (problem_of_world). REQUIRES: `problem` was made for the chain's
  // vocabulary.
  static Result<Study> create(const std::string& path, const Chain& chain, const StudyWorld& world,
                              const StudyLearning& learning, const std::optional<Problem>& problem = std::nullopt);

  // The same for those who need no more than the file: the chain goes once its bytes are there. Gives its hash.
  static Result<ChainHash> write_new(const std::string& path, Chain chain, const StudyWorld& world,
                                     const StudyLearning& learning, const std::optional<Problem>& problem);

  // Whether create() could make this file: finds out by making one beside it, which is gone again on return. For those
  // who work long before they create. Errors: as create().
  static Result<void> check_new(const std::string& path);

  // Errors, each naming the file: it does not exist, is not an SQLite database, is one but not a study, was written
  // by a newer version, is damaged. With Access::read nothing is written, and the calls below that write fail.
  static Result<Study> open(const std::string& path, Access access = Access::write);

  Study(Study&&) noexcept;
  Study& operator=(Study&&) noexcept;
  ~Study();  // leaves one file, without journals, unless another process has it open

  const std::string& path() const;
  const Chain& chain() const;
  const ChainHash& chain_hash() const;
  const StudyWorld& world() const;
  const StudyLearning& learning() const;
  const Problem& problem() const;

  // Replaces the problem: labels, units or the simulator changed. REQUIRES: made for the chain's vocabulary.
  Result<void> save_problem(const Problem& problem);
  // Changes the problem as the file has it now, which another process may have changed meanwhile, in one transaction.
  // What `change` says is returned as it is, and then nothing is saved.
  Result<void> change_problem(const std::function<Result<void>(Problem&)>& change);
  // Takes up what other processes made of it: problem() is that of the file now.
  Result<void> read_problem();

  // A new run, status running, owned by this process. Error (bad_input): another process that is alive runs one.
  Result<RunId> begin_run(const NewRun& run);

  // Takes over a run that is not finished. Errors: no such run; it is finished; the process that runs it is alive; or
  // it ran on another host (its state cannot be seen from here), unless take_over says that the user knows better.
  Result<ResumedRun> resume_run(RunId run, bool take_over = false);

  // One transaction: the statistics rows and the checkpoint, which replaces the one before.
  // `of_demes`: the same generations of each of several demes, [demes][generations]; empty: there is one deme.
  // REQUIRES: the run is this process's; at least one record, in their order; the last is the checkpoint's generation.
  // Error, also of finish_run(): the path leads to another file by now, or to none.
  Result<void> save_generations(RunId run, std::span<const GenerationRecord> records, const Checkpoint& checkpoint,
                                std::span<const std::vector<GenerationRecord>> of_demes = {});

  // Back to a checkpoint of this run, or before the first generation: what came after is forgotten, in one
  // transaction. REQUIRES: as save_generations().
  Result<void> rewind_run(RunId run, const std::optional<Checkpoint>& to);

  Result<void> finish_run(RunId run, const RunOutcome& outcome);

  // Replaces the run's front, in one transaction.
  Result<void> save_front(RunId run, const Front& front);

  Result<std::vector<RunRecord>> runs() const;  // by id
  Result<RunRecord> run(RunId run) const;       // error (bad_input): no such run; says which there are
  Result<std::optional<RunRecord>> last_run() const;
  Result<std::vector<GenerationRecord>> generations(RunId run) const;
  // Without demes: the run has one, or an earlier version wrote it.
  Result<DemeGenerations> deme_generations(RunId run) const;
  Result<std::optional<Checkpoint>> load_checkpoint(RunId run) const;
  // By position; without members: the run has none. Every member has the same measures.
  Result<Front> front(RunId run) const;

  // Errors: an empty name, one or a note that is too long (bad_input); the file cannot be written. The new tree's id.
  Result<std::int64_t> keep_tree(const std::string& name, const std::string& note, const Tree& tree);
  Result<void> forget_tree(std::int64_t id);         // error (bad_input): no such tree
  Result<std::vector<KeptTree>> kept_trees() const;  // by id

  // A number that changes whenever another connection, of this process or another, has written to the file.
  Result<std::int64_t> changes_by_others() const;

  // The run's result, or, while it has none, the best champion so far. Error (bad_input): not one generation was saved.
  Result<Tree> best_tree(RunId run) const;

 private:
  struct State;
  explicit Study(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace coppice
