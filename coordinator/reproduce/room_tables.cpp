#include "coordinator/reproduce/room_tables.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <optional>

#include "common/tree/text.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/learning/uav_room.hpp"
#include "coordinator/trust/verification_report.hpp"

namespace coppice {
namespace {

constexpr const char* kOurMap =
    "The thesis does not print its map. Ours was chosen so that the policy is close to the thesis' in states and "
    "reward.";

std::string percent(double share) { return fmt::format("{:.1f} %", 100.0 * share); }
std::string number(double value) { return fmt::format("{:.1f}", value); }

double coverage(const ControllerScore& score, const Chain& chain) {
  return static_cast<double>(score.matching_states) / static_cast<double>(chain.states());
}

// "median [lowest, highest]" over the trials; of an even number the lower of the two in the middle.
std::string spread(const std::vector<Trial>& trials, const std::function<double(const Trial&)>& value,
                   const std::function<std::string(double)>& text) {
  std::vector<double> values;
  values.reserve(trials.size());
  for (const Trial& trial : trials) {
    values.push_back(value(trial));
  }
  std::sort(values.begin(), values.end());
  return fmt::format("{} [{}, {}]", text(values[(values.size() - 1) / 2]), text(values.front()), text(values.back()));
}

std::string nodes_text(const Trial& trial) {
  return fmt::format("{} nodes, {} pruned", trial.tree.size(), trial.pruned.size());
}

std::vector<std::string> our_columns(const std::vector<Trial>& trials) {
  return {"Q-learning", fmt::format("BT, best of {} by fitness", trials.size()),
          fmt::format("median of {} seeds [range]", trials.size())};
}

using Row = Comparison::Row;

// The rows that every table about a tree has.
struct TreeRows {
  Row evolved;
  Row all;
  Row simulation;
  Row reward;
  Row size;
  Row collisions;
};

TreeRows tree_rows(const RoomRun& run, const std::vector<Trial>& trials) {
  const Trial& best = best_of(trials);
  TreeRows rows;
  rows.evolved = {"agreement along its walks in evolution",
                  {},
                  {"", percent(best.agreement),
                   spread(
                       trials, [](const Trial& t) { return t.agreement; }, percent)}};
  rows.all = {"action-selection for all states",
              {},
              {"100.0 %", percent(coverage(best.score, run.chain)),
               spread(
                   trials, [&](const Trial& t) { return coverage(t.score, run.chain); }, percent)}};
  rows.simulation = {
      "action-selection in simulation",
      {},
      {"100.0 %", fmt::format("{} +- {:.1f}", percent(best.score.agreement.mean), 100.0 * best.score.agreement.margin),
       spread(
           trials, [](const Trial& t) { return t.score.agreement.mean; }, percent)}};
  rows.reward = {"average reward",
                 {},
                 {fmt::format("{:.1f} +- {:.1f}", run.policy.reward.mean, run.policy.reward.margin),
                  fmt::format("{:.1f} +- {:.1f}", best.score.reward.mean, best.score.reward.margin),
                  spread(
                      trials, [](const Trial& t) { return t.score.reward.mean; }, number)}};
  rows.size = {"representation",
               {},
               {fmt::format("{} entries", run.chain.states() * run.chain.actions()), nodes_text(best),
                spread(
                    trials, [](const Trial& t) { return static_cast<double>(t.pruned.size()); },
                    [](double nodes) { return fmt::format("{:.0f}", nodes); }) +
                    " pruned"}};
  rows.collisions = {
      "collisions an episode",
      {},
      {fmt::format("{:.3f}", run.policy.collisions.mean), fmt::format("{:.3f}", best.score.collisions.mean),
       spread(
           trials, [](const Trial& t) { return t.score.collisions.mean; },
           [](double mean) { return fmt::format("{:.3f}", mean); })}};
  return rows;
}

void add_best(const Experiment& experiment, const std::vector<Trial>& trials, const RoomRun& run,
              Comparison& comparison) {
  const Trial& best = best_of(trials);
  comparison.remarks.push_back(fmt::format("Best by its own fitness: seed {}, found in generation {}, pruned: {}",
                                           best.seed, best.best_generation,
                                           to_text(best.pruned, run.chain.vocabulary())));
  comparison.remarks.push_back(fmt::format("Again: {}", command_of(experiment, best.seed, run.study)));
}

std::string observation(const std::array<std::uint8_t, 8>& sensors) {
  return fmt::format("({})", fmt::join(sensors, ","));
}

std::optional<std::size_t> find_state(const Chain& chain, const std::array<std::uint8_t, 8>& sensors) {
  for (std::size_t state = 0; state < chain.states(); ++state) {
    const auto features = chain.features_of(state);
    if (std::equal(features.begin(), features.end(), sensors.begin(), sensors.end())) {
      return state;
    }
  }
  return std::nullopt;
}

std::vector<std::string> strings(std::initializer_list<std::string_view> texts) { return {texts.begin(), texts.end()}; }

}  // namespace

Comparison table_four(const RoomRun& run, const Experiment& experiment, const std::vector<Trial>& trials) {
  Comparison table{.name = "Table IV",
                   .title = fmt::format("agreement objective, the tree acting, 400 generations ({} of {})",
                                        counted(run.simulate.episodes, "episode"), counted(run.simulate.steps, "step")),
                   .printed_columns = {"Q-learning", "BT", "BT adjusted"},
                   .our_columns = our_columns(trials),
                   .rows = {},
                   .remarks = {}};
  TreeRows rows = tree_rows(run, trials);
  rows.all.printed = {printed::kFourAll.begin(), printed::kFourAll.end()};
  rows.simulation.printed = {printed::kFourSimulation.begin(), printed::kFourSimulation.end()};
  rows.reward.printed = {printed::kFourReward.begin(), printed::kFourReward.end()};
  rows.size.printed = {printed::kFourSize.begin(), printed::kFourSize.end()};
  table.rows = {rows.evolved, rows.all, rows.simulation, rows.reward, rows.size, rows.collisions};
  table.remarks = {
      kOurMap,
      "The thesis shows one evolution, and does not say of how many. Its outcome depends on chance: the last "
      "column has what the same parameters give with other seeds. BT adjusted was made by hand; we add nothing by "
      "hand."};
  add_best(experiment, trials, run, table);
  return table;
}

Comparison tree_table(const TreeTable& shape, const RoomRun& run, const Experiment& experiment,
                      const std::vector<Trial>& trials) {
  Comparison table{.name = shape.name,
                   .title = shape.title,
                   .printed_columns = {"Q-learning", "BT"},
                   .our_columns = our_columns(trials),
                   .rows = {},
                   .remarks = shape.remarks};
  const printed::TwoColumns& p = shape.printed;
  TreeRows rows = tree_rows(run, trials);
  rows.all.printed = strings({p.all_policy, p.all_tree});
  rows.simulation.printed = strings({p.simulation_policy, p.simulation_tree});
  rows.reward.printed = strings({p.reward_policy, p.reward_tree});
  rows.size.printed = strings({p.entries, p.nodes});
  if (!p.q_score_tree.empty()) {
    const Trial& best = best_of(trials);
    table.rows.push_back({fmt::format("accumulated Q-score, {} steps", run.q_steps),
                          strings({p.q_score_policy, p.q_score_tree}),
                          {number(run.policy_q), number(best.accumulated_q),
                           spread(
                               trials, [](const Trial& t) { return t.accumulated_q; }, number)}});
    const auto times = [](double ratio) { return fmt::format("{:.2f}", ratio); };
    table.rows.push_back(
        {"  times the policy's",
         {"", times(std::stod(std::string(p.q_score_tree)) / std::stod(std::string(p.q_score_policy)))},
         {"", times(best.accumulated_q / run.policy_q),
          spread(
              trials, [&](const Trial& t) { return t.accumulated_q / run.policy_q; }, times)}});
  } else {
    table.rows.push_back(rows.evolved);
  }
  table.rows.insert(table.rows.end(), {rows.all, rows.simulation, rows.reward, rows.size, rows.collisions});
  add_best(experiment, trials, run, table);
  return table;
}

Comparison table_five_three(const RoomRun& run) {
  Comparison table{.name = "Table 5-3",
                   .title = "Q-values of three states (s0 to s7; 0 wall, 1 free, 3 trash)",
                   .printed_columns = {"move", "turn left", "turn right"},
                   .our_columns = {"move", "turn left", "turn right", "visits"},
                   .rows = {},
                   .remarks = {}};
  bool same = true;
  for (const printed::StateValues& values : printed::kFiveThree) {
    Row row{observation(values.sensors), {values.values.begin(), values.values.end()}, {"not met in learning"}};
    if (const auto state = find_state(run.chain, values.sensors); state) {
      row.ours.clear();
      for (std::size_t action = 0; action < run.chain.actions(); ++action) {
        row.ours.push_back(fmt::format("{:.5f}", run.chain.parts().q[*state * run.chain.actions() + action]));
      }
      row.ours.push_back(std::to_string(run.chain.parts().visits[*state]));
      const auto printed_best = std::max_element(
          values.values.begin(), values.values.end(),
          [](std::string_view a, std::string_view b) { return std::stod(std::string(a)) < std::stod(std::string(b)); });
      same =
          same && index_of(run.chain.policy(*state)) == static_cast<std::size_t>(printed_best - values.values.begin());
    }
    table.rows.push_back(std::move(row));
  }
  table.remarks = {
      same ? "The best action is the thesis' in all three states."
           : "The best action is not the thesis' in every state: with a learning rate of 0.5 that never falls, a "
             "Q-value is "
             "mostly its last few updates.",
      "The values differ with the map and with the last updates: where trash appears is chance, so Q does not converge "
      "(thesis Figure 15)."};
  return table;
}

Comparison table_five_four(const RoomRun& run) {
  Comparison table{
      .name = "Table 5-4",
      .title = fmt::format("successors of moving forward from {}: trash ahead", observation(printed::kTrashAhead)),
      .printed_columns = {"transitions", "probability"},
      .our_columns = {"transitions", "probability"},
      .rows = {},
      .remarks = {}};
  const auto from = find_state(run.chain, printed::kTrashAhead);
  if (!from) {
    table.remarks = {"Learning never met the state."};
    return table;
  }
  const std::size_t row = run.chain.row(*from, ActionId{0});
  const auto tries = static_cast<double>(run.chain.tries(row));
  const auto successors = run.chain.successors(row);
  const auto counts = run.chain.counts(row);
  std::uint64_t listed = 0;
  for (const printed::Successor& successor : printed::kFiveFour) {
    std::uint32_t count = 0;
    if (const auto state = find_state(run.chain, successor.sensors); state) {
      const auto found = std::lower_bound(successors.begin(), successors.end(), *state);
      count = found != successors.end() && *found == *state
                  ? counts[static_cast<std::size_t>(found - successors.begin())]
                  : 0;
    }
    listed += count;
    table.rows.push_back({observation(successor.sensors),
                          strings({successor.transitions, successor.probability}),
                          {std::to_string(count), percent(count / tries)}});
  }
  table.rows.push_back({"all others",
                        {"-", "-"},
                        {std::to_string(run.chain.tries(row) - listed),
                         percent(static_cast<double>(run.chain.tries(row) - listed) / tries)}});
  constexpr double kPrintedTries = 41664.0;  // the printed transitions added up
  table.remarks = {
      fmt::format("Ours has {} successors, from {} tries. The printed rows have 41,664 tries and add up to 99 %: "
                  "as many as {:.0f} of our {} episodes give, so they were not counted over a million.",
                  successors.size(), run.chain.tries(row), kPrintedTries / tries * static_cast<double>(run.episodes),
                  run.episodes),
      "The same shape: collecting mostly leads to seeing nothing, where Q is low. That is why a sum of Q-values "
      "rewards a tree that keeps looking at trash (Table 5-2)."};
  return table;
}

std::string remark_on_acting(const std::vector<Trial>& trials) {
  std::size_t colliding = 0;
  std::size_t losing = 0;
  for (const Trial& trial : trials) {
    colliding += trial.score.total_collisions > 0 ? 1U : 0U;
    losing += trial.score.agreement.mean < trial.agreement ? 1U : 0U;
  }
  return fmt::format(
      "Where the policy acts it moves on from every mistake of the tree. When the tree acts itself {} of {} agree less "
      "than "
      "they did in evolution, and {} collide; the thesis shows one that does.",
      losing, trials.size(), colliding);
}

std::string remark_on_spinning(const std::vector<Trial>& trials) {
  std::size_t spinning = 0;
  for (const Trial& trial : trials) {
    spinning += trial.score.reward.mean < 0.0 ? 1U : 0U;
  }
  return fmt::format(
      "{} of {} trees earn less than nothing: they turn to and fro beside trash, right every other time. That scores "
      "(8 - 4) / "
      "2 = 2 a step, more than the 1 of being right where there is none: the weights have the flaw of Table 5-2.",
      spinning, trials.size());
}

Comparison table_five_eight(const RoomRun& run, const std::vector<Trial>& trials) {
  const Trial& best = best_of(trials);
  const Trial& worst = *std::max_element(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
    return a.score.total_collisions < b.score.total_collisions;
  });
  Comparison table{.name = "Table 5-8",
                   .title = "ten runs of the tree of Table 5-7, and of the one that collides most",
                   .printed_columns = {"reward", "success"},
                   .our_columns = {fmt::format("seed {}: reward", best.seed), "success", "collisions",
                                   fmt::format("seed {}: reward", worst.seed), "success", "collisions"},
                   .rows = {},
                   .remarks = {}};
  const SimulateSettings ten{
      .episodes = printed::kFiveEightReward.size(), .steps = run.simulate.steps, .seed = run.simulate.seed};
  const auto of_best = simulate_tree(run.world, run.chain, best.tree, ten).value();
  const auto of_worst = simulate_tree(run.world, run.chain, worst.tree, ten).value();
  for (std::size_t i = 0; i < printed::kFiveEightReward.size(); ++i) {
    Row row{fmt::format("run {}", i + 1), strings({printed::kFiveEightReward[i], printed::kFiveEightSuccess[i]}), {}};
    for (const EpisodeRecord* record : {&of_best[i], &of_worst[i]}) {
      row.ours.push_back(fmt::format("{:.0f}", record->reward));
      row.ours.push_back(fmt::format("{:.0f}%", 100.0 * record->matches / std::max(record->steps, 1U)));
      row.ours.push_back(std::to_string(record->collisions));
    }
    table.rows.push_back(std::move(row));
  }
  table.remarks = {
      fmt::format("5 of the thesis' ten runs collide (-974 and less are some hundred collisions of -10). Over {} "
                  "the tree of seed {} collides {} times, that of seed {} {} times.",
                  counted(run.simulate.episodes, "episode"), best.seed, best.score.total_collisions, worst.seed,
                  worst.score.total_collisions),
      fmt::format("Runs 1 to 10 of the simulator's seed {}.", run.simulate.seed)};
  return table;
}

Result<Comparison> verification_count(const RoomRun& run, const std::vector<Trial>& trials) {
  constexpr const char* kRule = "never move when s3=0";
  const Result<Rule> rule = parse_rule(kRule, run.chain.vocabulary());
  if (!rule) {
    return tl::unexpected(rule.error());
  }
  const Tree& tree = best_of(trials).pruned;
  const Result<CheckedRule> checked = check_on(*rule, tree, run.chain);
  if (!checked) {
    return tl::unexpected(checked.error());
  }
  std::vector<std::size_t> deciding;  // of the trees that keep the rule
  for (const Trial& trial : trials) {
    const Result<RuleAnswer> answer = check_rule(*rule, trial.pruned, run.chain.vocabulary());
    if (!answer) {
      return tl::unexpected(answer.error());
    }
    if (answer->holds()) {
      deciding.push_back(answer->ticked());
    }
  }
  std::sort(deciding.begin(), deciding.end());
  std::size_t moves = 0;
  for (std::size_t state = 0; state < run.chain.states(); ++state) {
    moves += rule->applies(run.chain.features_of(state)) && rule->broken_by(run.chain.policy(state)) ? 1U : 0U;
  }
  Comparison table{.name = "VII, Easy verification",
                   .title = "what has to be looked at to know that nobody moves into a wall ahead",
                   .printed_columns = {"Q-table", "BT"},
                   .our_columns = {"Q-table", "BT of Table IV, pruned", fmt::format("over {} seeds", trials.size())},
                   .rows = {},
                   .remarks = {}};
  table.rows = {{"states with a wall ahead", {std::string(printed::kWallStates)}, {std::to_string(checked->states)}},
                {"state-action values",
                 {std::string(printed::kWallValues)},
                 {std::to_string(checked->states * run.chain.actions())}},
                {"nodes that decide there",
                 {"", std::string(printed::kWallNodes)},
                 {"", fmt::format("{} of {}", checked->answer.ticked(), tree.size()),
                  deciding.empty() ? "-" : fmt::format("{} to {}", deciding.front(), deciding.back())}},
                {"never moves there",
                 {"yes", "yes"},
                 {moves == 0 ? "yes, in all of them" : fmt::format("no, moves in {}", moves),
                  checked->answer.holds() ? "yes, for every observation" : "no",
                  fmt::format("{} of {}", deciding.size(), trials.size())}}};
  table.remarks = {
      "Nodes that decide: those that a tick with a wall ahead can come to. They are few where the wall is tested "
      "first; all "
      "that stands before it has to be looked at, too. The abstract of the thesis has 1448 values and 3 nodes.",
      "No room can have 488 such states with sensors that see nothing behind a wall: there are at most 441 "
      "(coordinator/learning/README.md).",
      fmt::format("Computed, not asserted: coppice verify {} --rule '{}' --tree '{}'", run.study, kRule,
                  to_text(tree, run.chain.vocabulary()))};
  if (checked->answer.broken) {
    table.remarks.push_back(fmt::format(
        "Broken where {}",
        observation_text(run.chain.vocabulary(), checked->answer.broken->features, checked->answer.broken->matters)));
  }
  return table;
}

}  // namespace coppice
