#include "common/evolution/epoch.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

#include "common/check.hpp"
#include "common/evolution/breeding.hpp"
#include "common/evolution/migration.hpp"

namespace coppice {
EpochCheck::EpochCheck(const Chain& chain, const EvolveConfig& config)
    : config_(config), breeding_(chain.vocabulary(), config.ga.shape()) {
  const auto objectives = objectives_of(config, chain.vocabulary());
  COPPICE_CHECK(objectives.has_value());
  objectives_ = objectives->size();
}

Result<void> EpochCheck::task(const EpochTask& task) const {
  const GaConfig& ga = config_.ga;
  const std::uint32_t begin = task.deme ? task.deme->generations : 0;
  if (task.number >= ga.demes || begin >= task.until || task.until > ga.generations || (task.deme && begin == 0)) {
    return bad_input(
        fmt::format("generations {} to {} of deme {}: expected fewer than {} demes and at most {} generations", begin,
                    task.until, task.number, ga.demes, ga.generations));
  }
  if (auto ok = individuals("migrants", task.migrants, 0, task.deme && ga.demes > 1 ? ga.migrants : 0); !ok) {
    return ok;
  }
  return task.deme ? deme(*task.deme, task.number) : Result<void>();
}

Result<void> EpochCheck::result(const EpochResult& result, const EpochTask& task) const {
  const std::uint32_t begin = task.deme ? task.deme->generations : 0;
  if (result.deme.generations != task.until || result.records.size() != task.until - begin) {
    return bad_input(fmt::format("{} generations with {} records: expected {} and {}", result.deme.generations,
                                 result.records.size(), task.until, task.until - begin));
  }
  for (std::size_t i = 0; i < result.records.size(); ++i) {
    const GenerationRecord& record = result.records[i];
    if (record.generation != begin + i || record.best.generation != begin + i ||
        !breeding_.within_limits(record.best.tree)) {
      return bad_input(fmt::format("record {}: expected generation {} and a champion within the limits", i, begin + i));
    }
  }
  if (auto ok = individuals("emigrants", result.emigrants, 0, config_.ga.demes > 1 ? config_.ga.migrants : 0); !ok) {
    return ok;
  }
  return deme(result.deme, task.number);
}

Result<void> EpochCheck::deme(const Deme& deme, std::uint32_t number) const {
  const std::size_t size = share_of(config_.ga, number).size;
  if (auto ok = individuals("population", deme.population, size, size); !ok) {
    return ok;
  }
  return individuals("archive", deme.archive, 0,
                     config_.ga.search == Search::front ? std::size_t{config_.front.members} : 0);
}

Result<void> EpochCheck::individuals(const char* name, const std::vector<Individual>& individuals, std::size_t least,
                                     std::size_t most) const {
  if (individuals.size() < least || individuals.size() > most) {
    return bad_input(fmt::format("{} of {} individuals: expected {} to {}", name, individuals.size(), least, most));
  }
  for (const Individual& individual : individuals) {
    if (!breeding_.within_limits(individual.tree)) {
      return bad_input(fmt::format("{}: a tree outside the limits of the configuration", name));
    }
    if (individual.tally.scores.size() != objectives_) {
      return bad_input(
          fmt::format("{}: a tally of {} scores: expected {}", name, individual.tally.scores.size(), objectives_));
    }
  }
  return {};
}

Result<EpochResult> run_epoch(DemeSearch& search, const EpochTask& task, const EvaluateTrees& evaluate) {
  search.take_up(task.number, task.deme ? *task.deme : Deme());
  search.admit(task.migrants);
  EpochResult result;
  std::uint32_t generation = task.deme ? task.deme->generations : 0;
  COPPICE_CHECK(generation < task.until);
  result.records.reserve(task.until - generation);
  for (; generation < task.until; ++generation) {
    std::vector<Tree> trees = search.breed();
    auto tallies = evaluate(trees, search.job(generation));
    if (!tallies) {
      return tl::unexpected(std::move(tallies).error());
    }
    result.records.push_back(search.settle(std::move(trees), std::move(*tallies)));
    if (task.count_meanings) {
      result.records.back().meanings = search.count_meanings();
    }
  }
  result.emigrants = search.emigrants();
  result.deme = search.deme();
  return result;
}

Result<EpochResult> EpochRunner::run(const EvolveConfig& config, const EpochTask& task,
                                     const std::function<bool(std::size_t)>& go_on) {
  if (config_ == nullptr || *config_ != config) {
    search_.reset();
    config_ = std::make_unique<const EvolveConfig>(config);
    auto search = DemeSearch::make(chain_->chain(), *config_);
    if (!search) {
      return tl::unexpected(search.error());
    }
    search_ = std::move(*search);
  }
  return run_epoch(*search_, task,
                   [&](std::span<const Tree> trees, const Job& job) { return evaluate(trees, job, go_on); });
}

Result<std::vector<Tally>> EpochRunner::evaluate(std::span<const Tree> trees, const Job& job,
                                                 const std::function<bool(std::size_t)>& go_on) {
  if (job_ == nullptr || job_->job() != job) {
    auto prepared = PreparedJob::make(chain_, job, job_);
    if (!prepared) {
      return tl::unexpected(prepared.error());
    }
    job_ = std::move(*prepared);
    evaluation_ ? evaluation_->begin(job_) : static_cast<void>(evaluation_.emplace(job_));
  }
  std::vector<Tally> tallies;
  tallies.reserve(trees.size());
  const std::size_t most = std::size_t{4} * evaluation_->trees_per_pass();
  std::size_t count = 0;  // since go_on was asked
  while (tallies.size() < trees.size()) {
    if (!go_on(count)) {
      return interrupted();
    }
    count = std::min(most, trees.size() - tallies.size());
    auto some = evaluation_->evaluate(trees.subspan(tallies.size(), count));
    std::move(some.begin(), some.end(), std::back_inserter(tallies));
  }
  return go_on(count) ? Result<std::vector<Tally>>(std::move(tallies)) : interrupted();
}

}  // namespace coppice
