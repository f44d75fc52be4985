#include "common/evolution/scalar_search.hpp"

#include <algorithm>
#include <unordered_set>

#include "common/check.hpp"
#include "common/evolution/breeding.hpp"
#include "common/evolution/evaluated.hpp"
#include "common/evolution/population.hpp"
#include "common/evolution/selection.hpp"
#include "common/fitness/meaning.hpp"

namespace coppice {
namespace {

class ScalarSearch : public DemeSearch {
 public:
  ScalarSearch(const Chain& chain, const EvolveConfig& config, ScalarFitness fitness)
      : chain_(chain),
        config_(config),
        fitness_(std::move(fitness)),
        breeding_(chain.vocabulary(), config.ga.shape()),
        meanings_(chain) {}

  Job job(std::uint32_t generation) const override { return job_of(config_, fitness_.objectives(), generation); }

  void take_up(std::uint32_t number, Deme deme) override {
    number_ = number;
    generations_ = deme.generations;
    std::vector<Tree> trees;
    std::vector<Tally> tallies;
    for (Individual& individual : deme.population) {
      trees.push_back(std::move(individual.tree));
      tallies.push_back(std::move(individual.tally));
    }
    population_ = Evaluated::of(std::move(trees), std::move(tallies), fitness_);
  }

  // In the places of the worst; who is there already does not come twice. All demes share the random numbers of a
  // generation, so the tally with which a migrant comes is the one that it would have here.
  void admit(const std::vector<Individual>& migrants) override {
    std::vector<std::size_t> ranked = ranking(population_.trees, population_.fitness);
    for (const Individual& migrant : migrants) {
      auto& trees = population_.trees;
      if (std::find(trees.begin(), trees.end(), migrant.tree) == trees.end()) {
        COPPICE_CHECK(ranked.size() > config_.ga.elites);
        const std::size_t slot = ranked.back();
        ranked.pop_back();
        trees[slot] = migrant.tree;
        population_.tallies[slot] = migrant.tally;
        population_.fitness[slot] = fitness_.of(migrant.tally);
      }
    }
  }

  std::vector<Tree> breed() override {
    if (generations_ == 0) {
      return first_population(breeding_, config_, chain_, 0, number_);
    }
    return next_population(breeding_, {population_.trees, population_.fitness}, config_.ga, config_.seed, generations_,
                           number_);
  }

  GenerationRecord settle(std::vector<Tree> trees, std::vector<Tally> tallies) override {
    population_ = Evaluated::of(std::move(trees), std::move(tallies), fitness_);
    return statistics_of(population_, generations_++);
  }

  std::uint32_t count_meanings() override {
    std::unordered_set<Meaning, MeaningHash> found;
    for (const Tree& tree : population_.trees) {
      found.insert(meanings_.of(tree));
    }
    return static_cast<std::uint32_t>(found.size());
  }

  Deme deme() const override {
    Deme deme{.generations = generations_, .population = {}, .archive = {}};
    for (std::size_t slot = 0; slot < population_.trees.size(); ++slot) {
      deme.population.push_back({population_.trees[slot], population_.tallies[slot]});
    }
    return deme;
  }

  // The best, each tree once.
  std::vector<Individual> emigrants() const override {
    std::vector<Individual> sent;
    if (config_.ga.demes == 1) {
      return sent;
    }
    for (const std::size_t slot : ranking(population_.trees, population_.fitness)) {
      const Tree& tree = population_.trees[slot];
      if (sent.size() == config_.ga.migrants) {
        break;
      }
      if (std::none_of(sent.begin(), sent.end(), [&](const Individual& other) { return other.tree == tree; })) {
        sent.push_back({tree, population_.tallies[slot]});
      }
    }
    return sent;
  }

 private:
  const Chain& chain_;
  const EvolveConfig& config_;
  ScalarFitness fitness_;
  Breeding breeding_;
  Meanings meanings_;
  Evaluated population_;
  std::uint32_t number_ = 0;
  std::uint32_t generations_ = 0;
};

}  // namespace

Result<std::unique_ptr<DemeSearch>> make_scalar_search(const Chain& chain, const EvolveConfig& config) {
  auto fitness = ScalarFitness::make(chain, config.fitness);
  if (!fitness) {
    return tl::unexpected(fitness.error());
  }
  return std::unique_ptr<DemeSearch>(std::make_unique<ScalarSearch>(chain, config, std::move(*fitness)));
}

}  // namespace coppice
