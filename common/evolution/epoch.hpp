// An epoch of a deme: a pure function of (deme, migrants, chain, configuration, deme number), so that it can run
// anywhere, twice, or again, and the result is the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/breeding.hpp"
#include "common/evolution/champion.hpp"
#include "common/evolution/config.hpp"
#include "common/evolution/deme.hpp"
#include "common/evolution/deme_search.hpp"
#include "common/fitness/evaluation.hpp"

namespace coppice {

struct EpochTask {
  std::uint32_t number = 0;          // of the deme, below ga.demes
  std::uint32_t until = 0;           // generations that the deme will have, more than it has
  std::shared_ptr<const Deme> deme;  // as the epoch before left it; null: it begins with nothing
  std::vector<Individual> migrants;  // whom another deme sent when that epoch ended
  bool count_meanings = false;       // in the records; it costs a table for each tree where the search has none
};

struct EpochResult {
  Deme deme;
  std::vector<GenerationRecord> records;  // of each generation, without `seconds`
  std::vector<Individual> emigrants;      // whom the deme sends, at most ga.migrants; none where there are no others
  bool operator==(const EpochResult&) const = default;
};

using EvaluateTrees = std::function<Result<std::vector<Tally>>(std::span<const Tree>, const Job&)>;

// Whoever evaluates. `search` is one of the configuration, whatever deme it had before. Errors: those of `evaluate`.
// REQUIRES: EpochCheck::task().
Result<EpochResult> run_epoch(DemeSearch& search, const EpochTask& task, const EvaluateTrees& evaluate);

// Whether what came from elsewhere fits a configuration: number and generations in range, a population of the deme's
// size, an archive, migrants and records within what the configuration allows, trees within its limits, a score for
// each objective in every tally. Immutable.
class EpochCheck {
 public:
  // `chain` and `config` outlive it. REQUIRES: check_search().
  EpochCheck(const Chain& chain, const EvolveConfig& config);

  std::size_t objectives() const { return objectives_; }
  Result<void> task(const EpochTask& task) const;
  // As a result of that task. REQUIRES: task(task).
  Result<void> result(const EpochResult& result, const EpochTask& task) const;

 private:
  Result<void> deme(const Deme& deme, std::uint32_t number) const;
  Result<void> individuals(const char* name, const std::vector<Individual>& individuals, std::size_t least,
                           std::size_t most) const;

  const EvolveConfig& config_;
  Breeding breeding_;
  std::size_t objectives_ = 0;
};

// One thread's: evaluates by itself, and keeps what epochs of one configuration share.
class EpochRunner {
 public:
  explicit EpochRunner(std::shared_ptr<const PreparedChain> chain) : chain_(std::move(chain)) {}

  // `go_on`, with the number of individuals evaluated since it was last asked, is asked every few passes; false: the
  // result is the error interrupted. Errors also: as DemeSearch::make() and PreparedJob::make(). REQUIRES:
  // check_search(), EpochCheck::task().
  Result<EpochResult> run(const EvolveConfig& config, const EpochTask& task,
                          const std::function<bool(std::size_t)>& go_on);

  // Individuals so far that meant what one before them had meant; for progress only: it depends on what else ran here.
  std::uint64_t repeated() const { return evaluation_ ? evaluation_->repeated() : 0; }

 private:
  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job,
                                      const std::function<bool(std::size_t)>& go_on);

  std::shared_ptr<const PreparedChain> chain_;
  std::unique_ptr<const EvolveConfig> config_;
  std::unique_ptr<DemeSearch> search_;  // of config_
  std::shared_ptr<const PreparedJob> job_;
  std::optional<Evaluation> evaluation_;
};

}  // namespace coppice
