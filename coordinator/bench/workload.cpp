#include "coordinator/bench/workload.hpp"

#include <unordered_set>
#include <utility>

#include "common/chain/random.hpp"
#include "common/fitness/meaning.hpp"
#include "common/tree/random_tree.hpp"

namespace coppice {
namespace {

constexpr std::uint64_t kSeed = 2016;
constexpr std::uint32_t kMostAttempts = 50;  // for each tree
constexpr std::uint32_t kEmptyGenerations = 100;
constexpr std::uint32_t kLightGenerations = 40;
constexpr std::uint32_t kMediumGenerations = 4;

// Trees that all mean something else, since those that mean the same are evaluated once. A chain too small for so many
// gets repetitions in the end.
std::vector<Tree> random_population(const Chain& chain, std::uint32_t count) {
  Xoshiro256 random(kSeed);
  const Below below = [&random](std::uint64_t n) { return random.below(n); };
  Meanings meanings(chain);
  std::unordered_set<Meaning, MeaningHash> met;
  std::vector<Tree> trees;
  trees.reserve(count);
  std::uint64_t attempts = std::uint64_t{kMostAttempts} * count;
  while (trees.size() < count) {
    Tree tree = grow_tree(chain.vocabulary(), TreeShape{}, true, below);
    if (met.insert(meanings.of(tree)).second || attempts == 0) {
      trees.push_back(std::move(tree));
    }
    attempts -= attempts > 0 ? 1 : 0;
  }
  return trees;
}

Workload workload(const std::string& name, std::vector<Tree> trees, std::uint32_t rollouts, std::uint32_t steps,
                  std::uint32_t generations) {
  Workload result{name, std::move(trees), {}, generations};
  result.job.rollouts = rollouts;
  result.job.steps = steps;
  result.job.seed = kSeed;
  return result;
}

}  // namespace

Job Workload::job_of(std::uint32_t generation) const {
  Job result = job;
  result.generation = generation;
  return result;
}

std::vector<Workload> standard_workloads(const Chain& chain) {
  const auto population = random_population(chain, kThesisPopulation);
  return {workload("empty", population, 1, 1, kEmptyGenerations),
          workload("light", population, 5, 100, kLightGenerations),
          workload("medium", population, 50, 1000, kMediumGenerations), workload("heavy", population, 500, 1000, 1)};
}

Workload light_workload(const Chain& chain, std::uint32_t population) {
  return workload("light", random_population(chain, population), 5, 100, 1);
}

}  // namespace coppice
