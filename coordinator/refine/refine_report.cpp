#include "coordinator/refine/refine_report.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace coppice {
namespace {

constexpr std::size_t kColumns = 11;
using Cells = std::array<std::string, kColumns>;

double of_states(const Score& score) {
  return static_cast<double>(score.tree.matching_states) / static_cast<double>(score.states);
}

Cells cells_of(const RefineRound& round) {
  const Gains gains = round.gains.value_or(Gains{});
  Cells cells = {fmt::format("{}", round.round), fmt::format("{}", round.states),      fmt::format("{}", gains.steps),
                 fmt::format("{}", gains.pairs), fmt::format("{}", gains.transitions), "interrupted"};
  if (const auto& score = round.score) {
    cells[5] = fmt::format("{}", score->nodes_pruned);
    cells[6] = fmt::format("{:.1f} %", 100.0 * of_states(*score));
    cells[7] =
        fmt::format("{:.1f} % +- {:.1f}", 100.0 * score->tree.agreement.mean, 100.0 * score->tree.agreement.margin);
    cells[8] = fmt::format("{:.1f} +- {:.1f}", score->tree.reward.mean, score->tree.reward.margin);
    cells[9] = score->expected ? fmt::format("{:.1f}", score->expected->tree.reward) : "";
    cells[10] = fmt::format("{}", score->tree.total_collisions);
  }
  return cells;
}

}  // namespace

std::string to_text(const std::vector<RefineRound>& rounds) {
  std::vector<Cells> rows = {{"round", "states", "+ steps", "+ pairs", "+ transitions", "nodes", "all states",
                              "simulated", "reward", "on the chain", "collisions"}};
  for (const RefineRound& round : rounds) {
    rows.push_back(cells_of(round));
  }
  std::array<std::size_t, kColumns> widths{};
  for (const Cells& row : rows) {
    for (std::size_t c = 0; c < kColumns; ++c) {
      widths[c] = std::max(widths[c], row[c].size());
    }
  }
  std::string text;
  for (const Cells& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < kColumns; ++c) {
      line += fmt::format("{}{:>{}}", c == 0 ? "" : "  ", row[c], widths[c]);
    }
    text += line.erase(line.find_last_not_of(' ') + 1) + '\n';
  }
  text +=
      "+: what the walks of the round before's tree added to the chain; reward: an episode, in the simulator\n"
      "and as the round's chain expects it; nodes: after pruning on the chain; +- is a 95 % interval\n";
  if (const auto best = best_of(rounds)) {
    text += fmt::format("best: round {}, fewest collisions, then highest reward in the simulator:\n{}\n",
                        rounds[*best].round, rounds[*best].score->tree_text);
  }
  return text;
}

nlohmann::ordered_json to_json(const std::vector<RefineRound>& rounds) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const RefineRound& round : rounds) {
    const Gains gains = round.gains.value_or(Gains{});
    nlohmann::ordered_json json = {{"round", round.round},
                                   {"study", round.study},
                                   {"chain", round.chain},
                                   {"states", round.states},
                                   {"seed", round.seed},
                                   {"added",
                                    {{"steps", gains.steps},
                                     {"states", gains.states},
                                     {"pairs", gains.pairs},
                                     {"transitions", gains.transitions}}},
                                   {"interrupted", !round.score}};
    if (const auto& score = round.score) {
      json["tree"] = score->tree_text;
      json["pruned"] = score->pruned_text;
      json["pruned_nodes"] = score->nodes_pruned;
      json["coverage"] = of_states(*score);
      json["agreement"] = score->tree.agreement.mean;
      json["reward"] = score->tree.reward.mean;
      json["reward_on_chain"] = score->expected ? nlohmann::ordered_json(score->expected->tree.reward) : nullptr;
      json["collisions"] = score->tree.total_collisions;
      json["unknown_steps"] = score->tree.unknown_steps;
      json["score"] = nlohmann::ordered_json::parse(to_json(*score));
    }
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace coppice
