#include "tests/coordinator/evolution/small_world.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "common/chain/random.hpp"
#include "common/fitness/objective.hpp"
#include "common/tree/text.hpp"
#include "common/tree/tick.hpp"

namespace coppice::testing {

Vocabulary small_vocabulary() {
  return {{{"a", {0, 1, 3}, true, false},
           {"b", {0, 1, 3}, true, false},
           {"c", {0, 1, 3}, true, false},
           {"d", {0, 1, 2}, true, true}},
          {"move", "left", "right"}};
}

Tree tree_of(std::string_view text) {
  auto tree = parse_tree(text, small_vocabulary());
  if (!tree) {
    throw std::logic_error(tree.error().message);
  }
  return *tree;
}

Chain small_chain() {
  ChainParts parts;
  parts.vocabulary = small_vocabulary();
  const auto& features = parts.vocabulary.features;
  const Tree policy = tree_of("(selector (sequence a=0 left) (sequence b=3 right) move)");
  constexpr std::uint32_t kStates = 81;
  Stream stream(7, Purpose::simulating, 0, 0);
  parts.row_begin.push_back(0);
  for (std::uint32_t s = 0; s < kStates; ++s) {
    const std::vector<std::uint8_t> row = {features[0].values[s % 3], features[1].values[s / 3 % 3],
                                           features[2].values[s / 9 % 3], features[3].values[s / 27]};
    parts.features.insert(parts.features.end(), row.begin(), row.end());
    parts.policy.push_back(tick(policy, row));
    parts.visits.push_back(1 + stream.below(100));
    for (int action = 0; action < 3; ++action) {
      const bool tried = stream.below(10) != 0;
      for (std::uint32_t next = 0; tried && next < kStates; ++next) {
        if (stream.below(16) == 0 || next == (s + 5) % kStates) {
          parts.successor.push_back(next);
          parts.count.push_back(static_cast<std::uint32_t>(1 + stream.below(9)));
        }
      }
      parts.row_begin.push_back(parts.successor.size());
      parts.reward_sum.push_back(tried ? static_cast<double>(stream.below(21)) - 10.0 : 0.0);
      parts.q.push_back(static_cast<double>(stream.below(1000)) / 64.0);
    }
  }
  auto chain = Chain::make(std::move(parts));
  if (!chain) {
    throw std::logic_error(chain.error().message);
  }
  return std::move(*chain);
}

Result<std::vector<Tally>> WalkingEvaluator::evaluate(std::span<const Tree> trees, const Job& job) {
  calls.push_back({{trees.begin(), trees.end()}, job});
  if (calls.size() - 1 == stop_at) {
    return tl::unexpected(error);
  }
  std::vector<Tally> tallies;
  for (const Tree& tree : trees) {
    tallies.push_back(tally(tree, job));
  }
  return tallies;
}

Tally WalkingEvaluator::tally(const Tree& tree, const Job& job) const {
  std::vector<ScoreTable> tables;
  for (const Objective& objective : job.objectives) {
    tables.push_back(make_score_table(chain_, objective).value());
  }
  const auto column = [&](ActionId action) { return action == kNoAction ? chain_.actions() : index_of(action); };
  Tally result{static_cast<std::uint32_t>(tree.size()), 0, 0, std::vector<std::int64_t>(tables.size(), 0)};
  const auto score = [&](std::size_t state, ActionId action, bool walking) {
    for (std::size_t o = 0; o < tables.size(); ++o) {
      if (along_walk(job.objectives[o].kind) == walking) {
        result.scores[o] += tables[o].scores[state * (chain_.actions() + 1) + column(action)];
      }
    }
  };
  for (std::size_t state = 0; state < chain_.states(); ++state) {
    score(state, tick(tree, chain_.features_of(state)), false);
  }
  for (std::uint32_t rollout = 0; rollout < job.rollouts; ++rollout) {
    std::size_t state = chain_.initial_state();
    for (std::uint32_t step = 0; step < job.steps; ++step) {
      const ActionId action = tick(tree, chain_.features_of(state));
      ++result.steps;
      result.matches += action == chain_.policy(state) ? 1 : 0;
      score(state, action, true);
      if (action == kNoAction) {
        continue;
      }
      const std::uint64_t bits = draw({job.seed, Purpose::rollout, job.generation, rollout, step});
      const std::size_t row = chain_.row(state, action);
      if (chain_.tries(row) == 0) {
        state = scale(bits, chain_.states());
        continue;
      }
      std::uint64_t left = scale(bits, chain_.tries(row));
      std::size_t i = 0;
      for (; left >= chain_.counts(row)[i]; ++i) {
        left -= chain_.counts(row)[i];
      }
      state = chain_.successors(row)[i];
    }
  }
  return result;
}

}  // namespace coppice::testing
