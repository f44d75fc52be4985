#include "tests/bench/thesis_population.hpp"

#include <unordered_set>

#include "common/check.hpp"
#include "common/fitness/meaning.hpp"
#include "common/stop.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/learning/world.hpp"

namespace coppice::bench {

std::shared_ptr<const Chain> uav_chain() {
  const World world = *load_world("uav");
  LearnSettings settings = default_settings(WorldKind::uav, Algorithm::q_learning);
  settings.episodes = 200'000;
  return std::make_shared<const Chain>(std::move(learn(world, settings, {})->chain));
}

std::vector<Tree> bred_trees(const std::shared_ptr<const Chain>& chain, std::size_t count) {
  const StopFlag stop;
  const auto evaluator = *SerialEvaluator::make(chain, stop);
  Meanings meanings(*chain);
  std::unordered_set<Meaning, MeaningHash> met;
  std::vector<Tree> trees;
  EvolveHooks hooks;
  hooks.generations_done = [&](std::span<const GenerationRecord> records,
                               const Checkpoint& checkpoint) -> Result<void> {
    for (const Tree& tree : checkpoint.population) {
      if (records.back().generation % 4 == 0 && trees.size() < count && met.insert(meanings.of(tree)).second) {
        trees.push_back(tree);
      }
    }
    return {};
  };
  const auto evolved = evolve(*chain, EvolveConfig{}, *evaluator, std::nullopt, hooks);
  COPPICE_CHECK(evolved.has_value() && trees.size() == count);
  return trees;
}

}  // namespace coppice::bench
