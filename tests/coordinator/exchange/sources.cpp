#include "tests/coordinator/exchange/sources.hpp"

#include <fmt/format.h>
#include <map>

namespace coppice::testing {

std::string lake_drn(const std::vector<std::string>& map) {
  const std::size_t states = map.size() * map.size();
  std::string text = fmt::format(
      "// Exported by hand\n@type: MDP\n@parameters\n\n@reward_models\nreward "
      "\n@nr_states\n{}\n@nr_choices\n{}\n@model\n",
      states, 4 * states);
  for (std::size_t state = 0; state < states; ++state) {
    const char cell = lake_cell(map, state);
    text += fmt::format("state {} [0]{}\n//[row={}\t& col={}]\n", state, cell == 'S' ? " init" : "", state / map.size(),
                        state % map.size());
    for (std::size_t action = 0; action < 4; ++action) {
      std::map<std::size_t, double> to;
      double reward = 0.0;
      for (const LakeStep& step : lake_steps(map, state, action)) {
        to[step.to] += 1.0 / 3.0;
        reward += step.reward / 3.0;
      }
      if (cell == 'H' || cell == 'G') {
        to = {{state, 1.0}};
        reward = 0.0;
      }
      constexpr std::array<const char*, 4> kNames{"(Left)", "(Down)", "(Right)", "(Up)"};
      text += fmt::format("\taction {} [{:.10g}]\n", kNames[action], reward);
      for (const auto& [successor, probability] : to) {
        text += fmt::format("\t\t{} : {:.10g}\n", successor, probability);
      }
    }
  }
  return text;
}

std::string lake_tables(const std::vector<std::string>& map) {
  const std::size_t states = map.size() * map.size();
  std::string observations;
  std::string initial;
  std::string table;
  for (std::size_t state = 0; state < states; ++state) {
    const char* comma = state == 0 ? "" : ",";
    observations += fmt::format("{}[{},{}]", comma, state / map.size(), state % map.size());
    initial += fmt::format("{}{}", comma, lake_cell(map, state) == 'S' ? 1 : 0);
    table += fmt::format("{}[", comma);
    for (std::size_t action = 0; action < 4; ++action) {
      table += action == 0 ? "[" : ",[";
      const char cell = lake_cell(map, state);
      if (cell == 'H' || cell == 'G') {
        table += fmt::format("[1.0,{},0,true]", state);
      } else {
        std::size_t number = 0;
        for (const LakeStep& step : lake_steps(map, state, action)) {
          const char to = lake_cell(map, step.to);
          table += fmt::format("{}[{},{},{},{}]", number++ == 0 ? "" : ",", 1.0 / 3.0, step.to, step.reward,
                               to == 'H' || to == 'G' ? "true" : "false");
        }
      }
      table += "]";
    }
    table += "]";
  }
  return fmt::format(
      R"({{"format":"coppice-tables-1","title":"lake","features":[{{"name":"row","label":"row from the top"}},"col"],)"
      R"("actions":["left","down","right","up"],"observations":[{}],"initial":[{}],"P":[{}]}})",
      observations, initial, table);
}

}  // namespace coppice::testing
