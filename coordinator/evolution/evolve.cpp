#include "coordinator/evolution/evolve.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>

#include "common/check.hpp"
#include "coordinator/evolution/breeding.hpp"
#include "coordinator/evolution/front_search.hpp"
#include "coordinator/evolution/population.hpp"
#include "coordinator/evolution/scalar_fitness.hpp"
#include "coordinator/evolution/selection.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

// Individuals that are asked for together and what came back.
struct Evaluated {
  std::vector<Tree> trees;
  std::vector<Tally> tallies;
  std::vector<double> fitness;
  std::size_t best = 0;  // index

  Champion champion(std::uint32_t generation) const {
    return {trees[best], generation, fitness[best], agreement_of(tallies[best])};
  }
};

GenerationRecord statistics_of(const Evaluated& population, std::uint32_t generation) {
  GenerationRecord record{.generation = generation, .best = population.champion(generation)};
  std::size_t measured = 0;
  for (std::size_t slot = 0; slot < population.trees.size(); ++slot) {
    record.mean_nodes += static_cast<double>(population.trees[slot].size());
    if (population.tallies[slot].steps > 0) {
      ++measured;
      record.mean_fitness += population.fitness[slot];
      record.mean_agreement += agreement_of(population.tallies[slot]);
    }
  }
  record.mean_nodes /= static_cast<double>(population.trees.size());
  record.mean_fitness /= static_cast<double>(std::max<std::size_t>(measured, 1));
  record.mean_agreement /= static_cast<double>(std::max<std::size_t>(measured, 1));
  record.distinct_trees = static_cast<std::uint32_t>(count_distinct(population.trees));
  record.evaluations = population.trees.size();
  return record;
}

class Evolution {
 public:
  Evolution(const Chain& chain, const EvolveConfig& config, ScalarFitness fitness, Evaluator& evaluator,
            const EvolveHooks& hooks)
      : chain_(chain),
        config_(config),
        fitness_(std::move(fitness)),
        breeding_(chain.vocabulary(), config.ga.shape()),
        evaluator_(evaluator),
        hooks_(hooks) {}

  Result<Evolved> run(std::optional<Checkpoint> start) {
    if (start) {
      if (auto ok = check_checkpoint(*start, config_.ga, breeding_); !ok) {
        return tl::unexpected(ok.error());
      }
      done_ = start->generation + 1;
      reached_ = std::move(*start);
    }
    while (done_ < config_.ga.generations) {
      if (auto ok = run_generation(done_); !ok) {
        return best_so_far(ok.error());
      }
    }
    return best_of_all();
  }

 private:
  Result<void> run_generation(std::uint32_t generation) {
    const Clock::time_point begin = Clock::now();
    auto population = evaluate(breed(generation), generation);
    if (!population) {
      return tl::unexpected(population.error());
    }
    GenerationRecord record = statistics_of(*population, generation);
    enter(record.best, reached_.hall_of_fame);
    reached_.generation = generation;
    reached_.population = std::move(population->trees);
    reached_.fitness = std::move(population->fitness);
    done_ = generation + 1;
    record.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return hooks_.generation_done ? hooks_.generation_done(record, reached_) : Result<void>();
  }

  std::vector<Tree> breed(std::uint32_t generation) const {
    if (generation == 0) {
      return first_population(breeding_, config_, chain_);
    }
    return next_population(breeding_, {reached_.population, reached_.fitness}, config_.ga, config_.seed, generation);
  }

  Result<Evaluated> evaluate(std::vector<Tree> trees, std::uint32_t generation) {
    auto tallies = evaluator_.evaluate(trees, job_of(config_, fitness_.objectives(), generation));
    if (!tallies) {
      return tl::unexpected(tallies.error());
    }
    COPPICE_CHECK(tallies->size() == trees.size());
    Evaluated result{std::move(trees), std::move(*tallies), {}};
    std::transform(result.tallies.begin(), result.tallies.end(), std::back_inserter(result.fitness),
                   [&](const Tally& tally) { return fitness_.of(tally); });
    result.best = ranking(result.trees, result.fitness).front();
    return result;
  }

  // All champions on one sample that none of them was chosen by.
  Result<Evolved> best_of_all() {
    std::vector<Tree> trees;
    for (const Champion& champion : reached_.hall_of_fame) {
      trees.push_back(champion.tree);
    }
    const auto champions = evaluate(std::move(trees), kFinalGeneration);
    if (!champions) {
      return best_so_far(champions.error());
    }
    const std::uint32_t first_led = reached_.hall_of_fame[champions->best].generation;
    return Evolved{champions->champion(first_led), champions->tallies[champions->best].steps, done_, false};
  }

  // After an interruption: what there is. Any other error goes to the caller.
  Result<Evolved> best_so_far(const Error& error) const {
    if (error.kind != ErrorKind::interrupted || reached_.hall_of_fame.empty()) {
      return tl::unexpected(error);
    }
    return Evolved{best_on_record(reached_.hall_of_fame), 0, done_, true};
  }

  const Chain& chain_;
  const EvolveConfig& config_;
  ScalarFitness fitness_;
  Breeding breeding_;
  Evaluator& evaluator_;
  const EvolveHooks& hooks_;
  Checkpoint reached_;
  std::uint32_t done_ = 0;  // generations
};

}  // namespace

Result<void> check_checkpoint(const Checkpoint& start, const GaConfig& ga, const Breeding& breeding) {
  if (start.generation >= ga.generations || start.population.size() != ga.population ||
      start.fitness.size() != start.population.size() || start.hall_of_fame.empty()) {
    return bad_input(
        fmt::format("checkpoint of generation {} with {} individuals, {} fitness values and {} champions: expected a "
                    "generation below {}, {} individuals and fitness values, and a champion",
                    start.generation, start.population.size(), start.fitness.size(), start.hall_of_fame.size(),
                    ga.generations, ga.population));
  }
  const auto fits = [&](const Tree& tree) { return breeding.within_limits(tree); };
  if (!std::all_of(start.population.begin(), start.population.end(), fits) ||
      !std::all_of(start.archive.begin(), start.archive.end(), fits) ||
      !std::all_of(start.hall_of_fame.begin(), start.hall_of_fame.end(),
                   [&](const Champion& champion) { return fits(champion.tree); })) {
    return bad_input(fmt::format("checkpoint of generation {}: holds a tree outside the limits of the configuration",
                                 start.generation));
  }
  return {};
}

void enter(const Champion& champion, HallOfFame& hall) {
  const auto known =
      std::find_if(hall.begin(), hall.end(), [&](const Champion& other) { return other.tree == champion.tree; });
  if (known == hall.end()) {
    hall.push_back(champion);
  } else if (champion.fitness > known->fitness) {
    known->fitness = champion.fitness;
    known->agreement = champion.agreement;
  }
}

const Champion& best_on_record(const HallOfFame& hall) {
  COPPICE_CHECK(!hall.empty());
  return *std::min_element(hall.begin(), hall.end(), [](const Champion& a, const Champion& b) {
    return a.fitness != b.fitness ? a.fitness > b.fitness : a.tree.size() < b.tree.size();
  });
}

Result<Evolved> evolve(const Chain& chain, const EvolveConfig& config, Evaluator& evaluator,
                       std::optional<Checkpoint> start, const EvolveHooks& hooks) {
  if (auto ok = check_config(config, chain.vocabulary()); !ok) {
    return tl::unexpected(ok.error());
  }
  if (config.ga.search == Search::front) {
    return search_front(chain, config, evaluator, std::move(start), hooks);
  }
  auto fitness = ScalarFitness::make(chain, config.fitness);
  if (!fitness) {
    return tl::unexpected(fitness.error());
  }
  return Evolution(chain, config, std::move(*fitness), evaluator, hooks).run(std::move(start));
}

}  // namespace coppice
