#include "coordinator/report/score.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "common/check.hpp"
#include "common/tree/simplify.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/text.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/learning/rooms.hpp"

namespace coppice {
namespace {

constexpr double kNormal95 = 1.96;            // the 97.5 % quantile of the standard normal distribution
constexpr std::uint64_t kFewestEpisodes = 2;  // one has no standard deviation
constexpr std::uint64_t kMostEpisodes = 100'000'000;

std::string percent(double part) { return fmt::format("{:.1f} %", 100.0 * part); }

std::string percent(const Estimate& estimate) {
  return fmt::format("{:.1f} % +- {:.1f}", 100.0 * estimate.mean, 100.0 * estimate.margin);
}

std::string number(const Estimate& estimate) { return fmt::format("{:.1f} +- {:.1f}", estimate.mean, estimate.margin); }

struct Row {
  std::string name;
  std::array<std::string, 3> ours;              // policy, tree, pruned tree
  std::array<std::string_view, 3> thesis = {};  // Q-learning, BT, BT adjusted; empty: not printed there
};

// The rows in columns, each as wide as its widest cell; the thesis' columns behind a bar, if wanted.
std::string lines_of(const std::vector<Row>& rows, bool with_thesis) {
  constexpr std::size_t kGap = 2;
  std::size_t name_width = 0;
  std::array<std::size_t, 3> widths{};
  std::array<std::size_t, 3> thesis_widths{};
  for (const Row& row : rows) {
    name_width = std::max(name_width, row.name.size());
    for (std::size_t i = 0; i < widths.size(); ++i) {
      widths[i] = std::max(widths[i], row.ours[i].size());
      thesis_widths[i] = std::max(thesis_widths[i], row.thesis[i].size());
    }
  }
  const auto line_of = [&](const Row& row) {
    std::string line = fmt::format("{:<{}}", row.name, name_width + kGap);
    for (std::size_t i = 0; i < widths.size(); ++i) {
      line += fmt::format("{:<{}}", row.ours[i], widths[i] + kGap);
    }
    if (with_thesis) {
      line += "| ";
      for (std::size_t i = 0; i < thesis_widths.size(); ++i) {
        line += fmt::format("{:<{}}", row.thesis[i], thesis_widths[i] + kGap);
      }
    }
    line.erase(line.find_last_not_of(' ') + 1);
    return line + '\n';
  };
  std::string text;
  if (with_thesis) {
    text += line_of({.name = "", .ours = {"this study", "", ""}, .thesis = {"the thesis", "", ""}});
  }
  for (const Row& row : rows) {
    text += line_of(row);
  }
  return text;
}

nlohmann::ordered_json json_of(const Estimate& estimate) {
  return {{"mean", estimate.mean}, {"margin", estimate.margin}};
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

nlohmann::ordered_json json_of(const ControllerScore& controller, const Score& score) {
  return {{"matching_states", controller.matching_states},
          {"agreement_over_states", share(controller.matching_states, score.states)},
          {"matching_seen", controller.matching_seen},
          {"agreement_over_seen", share(controller.matching_seen, score.seen_states)},
          {"agreement", json_of(controller.agreement)},
          {"reward", json_of(controller.reward)},
          {"collisions_per_episode", json_of(controller.collisions)},
          {"collisions", controller.total_collisions},
          {"steps", controller.steps},
          {"unknown_steps", controller.unknown_steps}};
}

}  // namespace

Estimate estimate(const std::vector<double>& samples) {
  COPPICE_CHECK(!samples.empty());
  const auto n = static_cast<double>(samples.size());
  double sum = 0.0;
  for (const double sample : samples) {
    sum += sample;
  }
  const double mean = sum / n;
  if (samples.size() == 1) {
    return {mean, 0.0};
  }
  double squares = 0.0;
  for (const double sample : samples) {
    squares += (sample - mean) * (sample - mean);
  }
  return {mean, kNormal95 * std::sqrt(squares / (n - 1.0) / n)};
}

ControllerScore controller_score(const std::vector<EpisodeRecord>& episodes) {
  ControllerScore score;
  score.episodes = episodes.size();
  std::vector<double> agreement;
  std::vector<double> reward;
  std::vector<double> collisions;
  for (const EpisodeRecord& episode : episodes) {
    score.steps += episode.steps;
    score.total_collisions += episode.collisions;
    score.unknown_steps += episode.unknown;
    // An episode that ended before its first step has nothing to disagree about.
    agreement.push_back(episode.steps == 0 ? 1.0 : static_cast<double>(episode.matches) / episode.steps);
    reward.push_back(episode.reward);
    collisions.push_back(episode.collisions);
  }
  score.agreement = estimate(agreement);
  score.reward = estimate(reward);
  score.collisions = estimate(collisions);
  return score;
}

Result<void> check_score_settings(const SimulateSettings& settings, std::string_view episodes_flag) {
  if (settings.episodes < kFewestEpisodes || settings.episodes > kMostEpisodes) {
    return bad_input(
        fmt::format("{} is {}: expected {} to {}", episodes_flag, settings.episodes, kFewestEpisodes, kMostEpisodes));
  }
  if (settings.steps < 1 || settings.steps > kMaxEpisodeSteps) {
    return bad_input(fmt::format("--steps is {}: expected 1 to {}", settings.steps, kMaxEpisodeSteps));
  }
  return {};
}

Result<Score> score_tree(const World& world, const Chain& chain, const Tree& tree, const SimulateSettings& settings,
                         const SimulateProgress& go_on, std::uint64_t seen_visits) {
  if (const Result<void> checked = check_score_settings(settings); !checked) {
    return tl::unexpected(checked.error());
  }
  if (chain.vocabulary() != vocabulary_of(world)) {
    return bad_input("the chain's features and actions are not those of its world: nothing can be simulated");
  }
  const Vocabulary& vocabulary = chain.vocabulary();
  const StateColumns columns(vocabulary, chain.parts().features);
  const Simplified pruned = simplify(tree, vocabulary, columns);

  Score score;
  score.world = world.kind;
  score.thesis_room = world.kind == WorldKind::uav && world.room == default_room();
  score.settings = settings;
  score.states = chain.states();
  score.seen_visits = seen_visits;
  score.seen_states =
      static_cast<std::size_t>(std::count_if(chain.parts().visits.begin(), chain.parts().visits.end(),
                                             [&](std::uint64_t visits) { return visits >= seen_visits; }));
  score.entries = chain.states() * chain.actions();
  score.nodes = tree.size();
  score.nodes_sound = simplify(tree, vocabulary).tree.size();
  score.nodes_pruned = pruned.tree.size();
  score.tree_text = to_text(tree, vocabulary);
  score.pruned_text = to_text(pruned.tree, vocabulary);
  const std::array<std::pair<ControllerScore*, const Tree*>, 3> controllers = {
      {{&score.policy, nullptr}, {&score.tree, &tree}, {&score.pruned, &pruned.tree}}};
  for (const auto& [controller, followed] : controllers) {
    const auto episodes = followed == nullptr ? simulate_policy(world, chain, settings, go_on)
                                              : simulate_tree(world, chain, *followed, settings, go_on);
    if (!episodes) {
      return tl::unexpected(episodes.error());
    }
    const ChainActions actions = followed == nullptr ? actions_of_policy(chain) : actions_of(chain, *followed);
    *controller = controller_score(*episodes);
    controller->matching_states = matching_states(chain, actions);
    controller->matching_seen = matching_states(chain, actions, seen_visits);
  }
  return score;
}

void add_exact(const Chain& chain, const Tree& tree, Score& score) {
  const auto expected = [&](const ChainActions& actions) {
    return expected_score(chain, actions, score.settings.steps);
  };
  // Pruning on the chain keeps the action table, so the pruned tree is the tree here.
  const ExpectedScore of_tree = expected(actions_of(chain, tree));
  score.expected = ExpectedScores{.policy = expected(actions_of_policy(chain)), .tree = of_tree, .pruned = of_tree};
}

std::string to_text(const Score& score) {
  const std::array<const ControllerScore*, 3> controllers = {&score.policy, &score.tree, &score.pruned};
  const auto ours = [&](const auto& text_of) {
    std::array<std::string, 3> cells;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      cells[i] = text_of(*controllers[i]);
    }
    return cells;
  };
  const auto over_states = [&](const ControllerScore& c) { return percent(share(c.matching_states, score.states)); };
  const auto over_seen = [&](const ControllerScore& c) { return percent(share(c.matching_seen, score.seen_states)); };
  std::vector<Row> rows = {
      {"", {"policy", "tree", "pruned tree"}, {"Q-learning", "BT", "BT adjusted"}},
      {"agreement over all states", ours(over_states), {"100 %", "66 %", "86 %"}},
      {fmt::format("  of {} seen {} times", score.seen_states, score.seen_visits), ours(over_seen), {}},
      {"agreement in simulation",
       ours([](const ControllerScore& c) { return percent(c.agreement); }),
       {"100 %", "93 %", "96 %"}},
      {"reward per episode", ours([](const ControllerScore& c) { return number(c.reward); }), {"283", "248", "266"}},
      {"representation",
       {fmt::format("{} entries", score.entries), counted(score.nodes, "node"), counted(score.nodes_pruned, "node")},
       {"3123 entries", "6 nodes", "20 nodes"}},
      {"collisions", ours([](const ControllerScore& c) {
         return fmt::format("{} ({:.3f} an episode)", c.total_collisions, c.collisions.mean);
       })},
      {"steps in unknown states",
       ours([](const ControllerScore& c) { return fmt::format("{} of {}", c.unknown_steps, c.steps); })},
  };
  if (score.expected) {
    const std::array<const ExpectedScore*, 3> expected = {&score.expected->policy, &score.expected->tree,
                                                          &score.expected->pruned};
    Row agreement{.name = "agreement along the chain", .ours = {}};
    Row reward{.name = "reward along the chain", .ours = {}};
    for (std::size_t i = 0; i < expected.size(); ++i) {
      agreement.ours[i] = fmt::format("{:.3f} % exactly", 100.0 * expected[i]->agreement);
      reward.ours[i] = fmt::format("{:.3f} exactly", expected[i]->reward);
    }
    rows.push_back(std::move(agreement));
    rows.push_back(std::move(reward));
  }
  std::string text = fmt::format("Table IV: {} of {}, seed {}, {}; +- is a 95 % interval\n",
                                 counted(score.settings.episodes, "episode"), counted(score.settings.steps, "step"),
                                 score.settings.seed, counted(score.states, "state"));
  text += lines_of(rows, score.thesis_room);
  text +=
      fmt::format("nodes: {} as evolved, {} after pruning that holds in every state, {} after pruning on the chain\n",
                  score.nodes, score.nodes_sound, score.nodes_pruned);
  return text;
}

std::string to_json(const Score& score) {
  nlohmann::ordered_json json = {
      {"world", name_of(score.world)},
      {"episodes", score.settings.episodes},
      {"steps_per_episode", score.settings.steps},
      {"seed", score.settings.seed},
      {"states", score.states},
      {"seen_visits", score.seen_visits},
      {"seen_states", score.seen_states},
      {"entries", score.entries},
      {"policy", json_of(score.policy, score)},
      {"tree", json_of(score.tree, score)},
      {"pruned", json_of(score.pruned, score)},
      {"nodes", {{"tree", score.nodes}, {"sound", score.nodes_sound}, {"pruned", score.nodes_pruned}}},
      {"tree_text", score.tree_text},
      {"pruned_text", score.pruned_text},
  };
  if (score.expected) {
    const auto expected_json = [](const ExpectedScore& expected) {
      return nlohmann::ordered_json{{"agreement", expected.agreement}, {"reward", expected.reward}};
    };
    json["exact"] = {{"policy", expected_json(score.expected->policy)},
                     {"tree", expected_json(score.expected->tree)},
                     {"pruned", expected_json(score.expected->pruned)}};
  }
  return json_line(json);
}

}  // namespace coppice
