#include "coordinator/reproduce/grid_tables.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/tree/simplify.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/text.hpp"
#include "common/tree/tick.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/learning/windy_grid.hpp"
#include "coordinator/reproduce/printed.hpp"

namespace coppice {
namespace {

std::string spread(std::vector<std::uint64_t> values) {
  std::sort(values.begin(), values.end());
  return fmt::format("{} [{}, {}]", values[(values.size() - 1) / 2], values.front(), values.back());
}

std::string percent_of(std::size_t part, std::size_t whole) { return fmt::format("{} of {} seeds", part, whole); }

// One column of the table of learning.
struct Column {
  std::string episodes;
  std::string converged;
  std::string way;
  std::string reward;
};

Column column_of(const std::vector<GridLearned>& all, Algorithm algorithm) {
  const LearnSettings settings = grid_settings(algorithm, 1);
  std::vector<std::uint64_t> converged;
  std::vector<std::uint64_t> steps;
  double best = -1e9;
  for (const GridLearned& one : all) {
    if (const std::uint64_t episode = converged_in(one.learned, settings); episode > 0) {
      converged.push_back(episode);
    }
    if (one.arrives) {
      steps.push_back(one.steps);
      best = std::max(best, one.reward);
    }
  }
  Column column;
  column.episodes = fmt::format("{}, then {} greedy", settings.episodes, settings.greedy_episodes);
  column.converged =
      converged.empty() ? "none" : fmt::format("{}, {}", spread(converged), percent_of(converged.size(), all.size()));
  column.way =
      steps.empty() ? "none" : fmt::format("{} steps, {}", spread(steps), percent_of(steps.size(), all.size()));
  column.reward = steps.empty() ? "-" : fmt::format("{:.0f}", best);
  return column;
}

}  // namespace

LearnSettings grid_settings(Algorithm algorithm, std::uint64_t seed) {
  LearnSettings settings = default_settings(WorldKind::windy, algorithm);
  settings.greedy_episodes = kGreedyEpisodes;
  settings.seed = seed;
  return settings;
}

Result<GridLearned> learn_grid(Algorithm algorithm, std::uint64_t seed) {
  const World world{WorldKind::windy, ""};
  const LearnSettings settings = grid_settings(algorithm, seed);
  Result<Learned> learned = learn(world, settings, {});
  if (!learned) {
    return tl::unexpected(std::move(learned).error());
  }
  const EpisodeRecord walked =
      simulate_policy(world, learned->chain, {.episodes = 1, .steps = settings.steps, .seed = 1})->front();
  const bool arrives = !greedy_way(learned->chain).empty();
  return GridLearned{std::move(*learned), arrives, walked.steps, walked.reward};
}

std::uint64_t converged_in(const Learned& learned, const LearnSettings& settings) {
  return learned.last_change_episode == settings.episodes + settings.greedy_episodes ? 0
                                                                                     : learned.last_change_episode + 1;
}

Comparison grid_learning_table(const std::vector<GridLearned>& q_learning, const std::vector<GridLearned>& sarsa) {
  const Column q = column_of(q_learning, Algorithm::q_learning);
  const Column s = column_of(sarsa, Algorithm::sarsa);
  Comparison table{.name = "Table 4-1",
                   .title = fmt::format("windy grid world, seeds 1 to {}: median [range]", q_learning.size()),
                   .printed_columns = {"Q-learning", "SARSA"},
                   .our_columns = {"Q-learning", "SARSA"},
                   .rows = {},
                   .remarks = {}};
  const auto printed = [](const auto& cells) { return std::vector<std::string>(cells.begin(), cells.end()); };
  table.rows = {
      {"episodes", printed(printed::kGridEpisodes), {q.episodes, s.episodes}},
      {"discount factor", printed(printed::kGridGamma), {"0.8", "0.9"}},
      {"converged at episode", printed(printed::kGridConverged), {q.converged, s.converged}},
      {"greedy way to the goal", {}, {q.way, s.way}},
      {"highest reward of an episode", printed(printed::kGridReward), {q.reward, s.reward}},
  };
  table.remarks = {
      "Converged: no value of Q changes by 1e-8 or more in any later episode. SARSA is printed to converge in episode "
      "269 "
      "of 200, so exploration had ended by then: we let both go on without it, too. SARSA values what it explores, "
      "so "
      "it cannot converge before exploration ends. Again: coppice learn -o FILE --world windy --algorithm sarsa "
      "--greedy-episodes 500 --seed N",
      "The thesis does not print its grid. In Sutton and Barto's, which it adapts, the goal is 15 of the 25 allowed "
      "steps "
      "away and no seed finds it in 200 episodes, so ours has 2000. The shortest way earns 9 - 14 = -5 here; the "
      "printed "
      "-13 would take a way of 23 steps.",
  };
  return table;
}

std::vector<std::size_t> greedy_way(const Chain& chain) {
  std::vector<std::size_t> way;
  std::size_t state = chain.initial_state();
  // The chain is deterministic, so a way longer than all states never ends.
  while (way.size() <= chain.states()) {
    way.push_back(state);
    const auto successors = chain.successors(chain.row(state, chain.policy(state)));
    if (successors.size() != 1) {
      return {};
    }
    state = successors.front();
    if (state == chain.initial_state()) {  // reached the goal: the walk renews itself (learning/README.md)
      const bool arrived = chain.mean_reward(chain.row(way.back(), chain.policy(way.back()))) > 0.0;
      return arrived ? way : std::vector<std::size_t>();
    }
  }
  return {};
}

GridTree on_the_way(const Tree& tree, std::uint64_t seed, const Chain& chain) {
  const std::vector<std::size_t> way = greedy_way(chain);
  GridTree result{.tree = tree, .seed = seed, .follows = !way.empty()};
  if (way.empty()) {
    return result;
  }
  std::vector<std::uint8_t> features;
  for (const std::size_t state : way) {
    const auto of_state = chain.features_of(state);
    features.insert(features.end(), of_state.begin(), of_state.end());
  }
  result.tree = simplify(tree, chain.vocabulary(), StateColumns(chain.vocabulary(), features)).tree;
  for (const std::size_t state : way) {
    result.follows = result.follows && tick(result.tree, chain.features_of(state)) == chain.policy(state);
  }
  return result;
}

Comparison grid_tree_table(const std::vector<GridTree>& trees, const GridLearned& policy) {
  const Chain& chain = policy.learned.chain;
  const GridTree* smallest = nullptr;
  std::size_t following = 0;
  std::size_t small = 0;
  constexpr std::size_t kThesisNodes = 9;
  for (const GridTree& tree : trees) {
    if (!tree.follows) {
      continue;
    }
    ++following;
    small += tree.tree.size() <= kThesisNodes ? 1U : 0U;
    smallest = smallest == nullptr || tree.tree.size() < smallest->tree.size() ? &tree : smallest;
  }
  Comparison table{.name = "Figure 4-4a",
                   .title = "a tree that follows the same shortest way through the windy grid",
                   .printed_columns = {"Q-learning", "BT, by hand"},
                   .our_columns = {"Q-learning", "BT, evolved"},
                   .rows = {},
                   .remarks = {}};
  table.rows = {{"representation",
                 {std::string(printed::kGridEntries), std::string(printed::kGridNodes)},
                 {fmt::format("{} entries", chain.states() * chain.actions()),
                  smallest == nullptr ? "none found" : fmt::format("{} nodes", smallest->tree.size())}},
                {"steps to the goal",
                 {"", ""},
                 {std::to_string(policy.steps), smallest == nullptr ? "-" : std::to_string(policy.steps)}}};
  table.remarks = {
      fmt::format("{} of {} evolutions follow the policy on every step of its way, {} of them with {} nodes or "
                  "fewer after pruning on the way's states.",
                  following, trees.size(), small, kThesisNodes)};
  if (smallest != nullptr) {
    table.remarks.push_back(
        fmt::format("The smallest, seed {}: {}", smallest->seed, to_text(smallest->tree, chain.vocabulary())));
  }
  return table;
}

}  // namespace coppice
