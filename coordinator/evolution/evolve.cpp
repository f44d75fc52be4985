#include "coordinator/evolution/evolve.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>

#include "common/check.hpp"
#include "coordinator/evolution/breeding.hpp"
#include "coordinator/evolution/evaluated.hpp"
#include "coordinator/evolution/front_search.hpp"
#include "coordinator/evolution/population.hpp"
#include "coordinator/evolution/scalar_fitness.hpp"
#include "coordinator/evolution/selection.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

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
    auto population = evaluate(breed(generation), generation, config_, fitness_, evaluator_);
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

  // All champions on one sample that none of them was chosen by.
  Result<Evolved> best_of_all() {
    std::vector<Tree> trees;
    for (const Champion& champion : reached_.hall_of_fame) {
      trees.push_back(champion.tree);
    }
    const auto champions = evaluate(std::move(trees), kFinalGeneration, config_, fitness_, evaluator_);
    if (!champions) {
      return best_so_far(champions.error());
    }
    const std::size_t best = champions->best();
    const std::uint32_t first_led = reached_.hall_of_fame[best].generation;
    return Evolved{champions->champion(best, first_led), champions->tallies[best].steps, done_, false};
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
