#include "coordinator/evolution/deme_evolution.hpp"

#include <algorithm>
#include <chrono>
#include <deque>
#include <iterator>

#include "common/check.hpp"
#include "common/evolution/deme_search.hpp"
#include "common/evolution/migration.hpp"
#include "coordinator/dispatch/deme_evolver.hpp"
#include "coordinator/evolution/deme_graph.hpp"
#include "coordinator/evolution/final_choice.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

// Breeds here and evaluates elsewhere, one epoch after another.
class SlotwiseEvolver : public DemeEvolver {
 public:
  SlotwiseEvolver(DemeSearch& search, Evaluator& evaluator) : search_(search), evaluator_(evaluator) {}

  void submit(std::uint64_t ticket, std::shared_ptr<const EvolveConfig>, EpochTask task) override {
    waiting_.emplace_back(ticket, std::move(task));
  }

  Result<Finished> next() override {
    COPPICE_CHECK(!waiting_.empty());
    const auto [ticket, task] = std::move(waiting_.front());
    waiting_.pop_front();
    auto result = run_epoch(
        search_, task, [this](std::span<const Tree> trees, const Job& job) { return evaluator_.evaluate(trees, job); });
    if (!result) {
      waiting_.clear();
      return tl::unexpected(std::move(result).error());
    }
    return Finished{ticket, std::move(*result)};
  }

 private:
  DemeSearch& search_;
  Evaluator& evaluator_;
  std::deque<std::pair<std::uint64_t, EpochTask>> waiting_;
};

class DemeEvolution {
 public:
  explicit DemeEvolution(EvolutionParts parts)
      : chain_(parts.chain),
        config_(std::make_shared<const EvolveConfig>(parts.config)),
        choice_(std::move(parts.choice)),
        search_(std::move(parts.search)),
        evaluator_(parts.evaluator),
        hooks_(parts.hooks),
        slotwise_(*search_, evaluator_) {}

  Result<Evolved> run(std::optional<Checkpoint> start) {
    std::optional<DemeGraph> graph;
    if (start) {
      auto resumed = go_on_from(std::move(*start));
      if (!resumed) {
        return best_so_far(resumed.error());
      }
      graph.emplace(std::move(*resumed));
    } else {
      graph.emplace(*config_);
    }
    if (auto ok = run_epochs(*graph); !ok) {
      return best_so_far(ok.error());
    }
    const std::vector<Individual> archive = choice_.united_archive(demes_);
    const Reached reached{done_, hall_, archive};
    auto tallies = evaluate_some(evaluator_, choice_.finalists(reached), choice_.job());
    return tallies ? choice_.answer(reached, std::move(*tallies)) : best_so_far(tallies.error());
  }

 private:
  Result<void> run_epochs(DemeGraph& graph) {
    DemeEvolver* const demes = evaluator_.demes(*config_);
    DemeEvolver& evolver = demes == nullptr ? slotwise_ : *demes;
    row_began_ = Clock::now();
    while (done_ < config_->ga.generations) {
      for (EpochTask& task : graph.take_ready()) {
        const std::uint32_t number = task.number;
        task.count_meanings = hooks_.count_meanings;
        evolver.submit(number, config_, std::move(task));
      }
      auto finished = evolver.next();
      if (!finished) {
        return tl::unexpected(std::move(finished).error());
      }
      graph.settle(static_cast<std::uint32_t>(finished->ticket), std::move(finished->result));
      while (auto row = graph.take_row()) {
        if (auto ok = end_epoch(std::move(*row)); !ok) {
          return ok;
        }
      }
    }
    return {};
  }

  Result<void> end_epoch(EpochRow row) {
    const Clock::time_point now = Clock::now();
    const std::size_t generations = row.records.front().size();
    const double seconds = std::chrono::duration<double>(now - row_began_).count() / static_cast<double>(generations);
    row_began_ = now;
    std::vector<GenerationRecord> records;
    for (std::size_t i = 0; i < generations; ++i) {
      std::vector<GenerationRecord> of_demes;
      of_demes.reserve(row.records.size());
      for (const auto& of_deme : row.records) {
        of_demes.push_back(of_deme[i]);
      }
      records.push_back(united(of_demes, config_->ga));
      records.back().seconds = seconds;
      enter(records.back().best, hall_);
    }
    if (hooks_.demes_done) {
      hooks_.demes_done(row.records);
    }
    demes_ = std::move(row.demes);
    done_ = demes_.front()->generations;
    return hooks_.generations_done ? hooks_.generations_done(records, checkpoint()) : Result<void>();
  }

  Result<DemeGraph> go_on_from(Checkpoint start) {
    const std::uint32_t epochs = start.generation / epoch_length(config_->ga) + 1;
    auto demes = measured_again(start, *config_, Breeding(chain_.vocabulary(), config_->ga.shape()),
                                search_->job(start.generation), evaluator_);
    if (!demes) {
      return tl::unexpected(demes.error());
    }
    std::vector<DemeGraph::Stood> stood;
    for (std::uint32_t number = 0; number < config_->ga.demes; ++number) {
      Deme& deme = (*demes)[number];
      search_->take_up(number, deme);
      stood.push_back({std::make_shared<const Deme>(std::move(deme)), search_->emigrants()});
      demes_.push_back(stood.back().deme);
    }
    hall_ = std::move(start.hall_of_fame);
    done_ = start.generation + 1;
    return DemeGraph(*config_, epochs, std::move(stood));
  }

  Checkpoint checkpoint() const {
    Checkpoint checkpoint{.generation = done_ - 1, .population = {}, .fitness = {}, .hall_of_fame = hall_};
    for (const auto& deme : demes_) {
      for (const Individual& individual : deme->population) {
        checkpoint.population.push_back(individual.tree);
        checkpoint.fitness.push_back(choice_.fitness_of(individual.tally));
      }
      for (const Individual& member : deme->archive) {
        checkpoint.archive.push_back(member.tree);
      }
      if (demes_.size() > 1) {
        checkpoint.kept.push_back(deme->archive.size());
      }
    }
    return checkpoint;
  }

  // After an interruption: what the last whole epoch left. Any other error goes to the caller.
  Result<Evolved> best_so_far(const Error& error) const {
    if (error.kind != ErrorKind::interrupted || hall_.empty()) {
      return tl::unexpected(error);
    }
    const std::vector<Individual> archive = choice_.united_archive(demes_);
    return choice_.interrupted({done_, hall_, archive});
  }

  const Chain& chain_;
  const std::shared_ptr<const EvolveConfig> config_;
  FinalChoice choice_;
  std::unique_ptr<DemeSearch> search_;  // to read checkpoints, and where demes are bred here
  Evaluator& evaluator_;
  const EvolveHooks& hooks_;
  SlotwiseEvolver slotwise_;

  // After the last whole epoch.
  std::vector<std::shared_ptr<const Deme>> demes_;
  HallOfFame hall_;
  std::uint32_t done_ = 0;  // generations
  Clock::time_point row_began_;
};

}  // namespace

GenerationRecord united(std::span<const GenerationRecord> of_demes, const GaConfig& ga) {
  COPPICE_CHECK(of_demes.size() == ga.demes);
  GenerationRecord record = of_demes.front();
  record.mean_fitness = record.mean_agreement = record.mean_nodes = record.seconds = 0.0;
  record.distinct_trees = 0;
  record.meanings = 0;
  record.evaluations = 0;
  for (std::uint32_t deme = 0; deme < ga.demes; ++deme) {
    const GenerationRecord& other = of_demes[deme];
    COPPICE_CHECK(other.generation == record.generation);
    if (other.best.fitness > record.best.fitness ||
        (other.best.fitness == record.best.fitness && other.best_nodes() < record.best_nodes())) {
      record.best = other.best;
    }
    const double share = static_cast<double>(share_of(ga, deme).size) / static_cast<double>(ga.population);
    record.mean_fitness += share * other.mean_fitness;
    record.mean_agreement += share * other.mean_agreement;
    record.mean_nodes += share * other.mean_nodes;
    record.distinct_trees += other.distinct_trees;
    record.meanings += other.meanings;
    record.evaluations += other.evaluations;
  }
  return record;
}

Result<Evolved> evolve_demes(EvolutionParts parts, std::optional<Checkpoint> start) {
  return DemeEvolution(std::move(parts)).run(std::move(start));
}

}  // namespace coppice
