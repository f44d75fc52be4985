#include "tests/fuzz/epochs.hpp"

#include <string_view>
#include <vector>

#include "common/check.hpp"
#include "common/evolution/migration.hpp"
#include "common/tree/text.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

constexpr std::uint32_t kEpoch = 2;  // generations

EvolveConfig config_of(Search search) {
  EvolveConfig config;
  config.seed = 0x0123456789ABCDEF;
  config.ga.search = search;
  config.ga.generations = 3 * kEpoch;
  config.ga.population = 9;
  config.ga.demes = 2;
  config.ga.epoch = kEpoch;
  config.ga.migrants = 2;
  config.ga.founders = "(selector (sequence s3=0 turn_left) move); turn_right";
  config.rollout.rollouts = 2;
  config.rollout.steps = 10;
  config.fitness.coverage = 0.5;
  config.fitness.shaped = 0.25;
  config.fitness.rules = {{{"s3=3", "x<=4"}, 8, -4}, {{}, 1, 0}};
  config.front.objectives = {measure_of(ObjectiveKind::agreement), measure_of(ObjectiveKind::coverage), kNodesMeasure};
  config.front.members = 5;
  return config;
}

std::vector<Individual> individuals(std::size_t count, std::size_t objectives) {
  static constexpr std::string_view kTrees[] = {"move", "(sequence s3=0 turn_left)",
                                                "(selector (sequence s3=0 x<=4 turn_left) (sequence y<=10 move))",
                                                "(selector s0=1 turn_right)"};
  std::vector<Individual> result;
  for (std::size_t i = 0; i < count; ++i) {
    auto tree = parse_tree(kTrees[i % std::size(kTrees)], words());
    COPPICE_CHECK(tree.has_value());
    Tally tally{static_cast<std::uint32_t>(tree->size()), 3 * i, 20, {}};
    for (std::size_t score = 0; score < objectives; ++score) {
      tally.scores.push_back((static_cast<std::int64_t>(i) - 2) << (11 * score));
    }
    result.push_back({std::move(*tree), std::move(tally)});
  }
  return result;
}

Deme deme_of(const EvolveConfig& config, std::uint32_t number, std::uint32_t generations, std::size_t objectives) {
  return {.generations = generations,
          .population = individuals(share_of(config.ga, number).size, objectives),
          .archive = individuals(config.ga.search == Search::front ? config.front.members - 1 : 0, objectives)};
}

}  // namespace

SampleEpoch sample_epoch(std::size_t which, const Chain& chain) {
  COPPICE_CHECK(which < kSampleEpochs);
  const bool begins = which % 2 == 0;
  const auto config = std::make_shared<const EvolveConfig>(config_of(which < 2 ? Search::scalar : Search::front));
  const std::size_t objectives = EpochCheck(chain, *config).objectives();
  const std::uint32_t number = begins ? 0 : 1;
  SampleEpoch sample{
      config, {.number = number, .until = begins ? kEpoch : 2 * kEpoch, .deme = nullptr, .migrants = {}}, {}};
  if (!begins) {
    sample.task.deme = std::make_shared<const Deme>(deme_of(*config, number, kEpoch, objectives));
    sample.task.migrants = individuals(config->ga.migrants, objectives);
    sample.task.count_meanings = true;
  }
  sample.result.deme = deme_of(*config, number, sample.task.until, objectives);
  sample.result.emigrants = individuals(config->ga.migrants, objectives);
  for (std::uint32_t generation = sample.task.until - kEpoch; generation < sample.task.until; ++generation) {
    GenerationRecord record{.generation = generation,
                            .best = {sample.result.emigrants.back().tree, generation, 0.75, 0.5}};
    record.mean_fitness = -0.0;
    record.mean_agreement = 0.25;
    record.mean_nodes = 3.5;
    record.distinct_trees = 4;
    record.meanings = sample.task.count_meanings ? 3 : 0;
    record.evaluations = share_of(config->ga, number).size;
    sample.result.records.push_back(std::move(record));
  }
  return sample;
}

}  // namespace coppice::fuzz
