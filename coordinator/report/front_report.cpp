#include "coordinator/report/front_report.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/tree/text.hpp"
#include "coordinator/console/json_line.hpp"

namespace coppice {

bool is_share(Measure measure) {
  if (!is_objective(measure)) {
    return false;
  }
  const ObjectiveKind kind = kind_of(measure);
  return kind == ObjectiveKind::agreement || kind == ObjectiveKind::coverage || kind == ObjectiveKind::visits ||
         kind == ObjectiveKind::seen;
}

std::string measure_text(Measure measure, double value) {
  if (is_share(measure)) {
    return fmt::format("{:.1f} %", 100.0 * value);
  }
  if (!is_objective(measure)) {
    return fmt::format("{:.0f}", value);
  }
  return kind_of(measure) == ObjectiveKind::expected_return ? fmt::format("{:.1f}", value)
                                                            : fmt::format("{:.4f}", value);
}

std::string to_text(const Front& front, std::optional<std::size_t> picked,
                    const std::vector<ControllerScore>& simulated) {
  constexpr std::size_t kGap = 2;
  std::vector<std::vector<std::string>> rows(1, {"#"});
  for (const Measure measure : front.measures) {
    rows[0].emplace_back(name_of(measure));
  }
  if (!simulated.empty()) {
    for (const char* name : {"simulated: agreement", "reward", "collisions"}) {
      rows[0].emplace_back(name);
    }
  }
  rows[0].emplace_back("fitness");
  for (std::size_t i = 0; i < front.members.size(); ++i) {
    std::vector<std::string> row = {fmt::format("{}", i)};
    for (std::size_t m = 0; m < front.measures.size(); ++m) {
      row.push_back(measure_text(front.measures[m], front.members[i].values[m]));
    }
    if (!simulated.empty()) {
      row.push_back(fmt::format("{:.1f} %", 100.0 * simulated[i].agreement.mean));
      row.push_back(fmt::format("{:.1f} +- {:.1f}", simulated[i].reward.mean, simulated[i].reward.margin));
      row.push_back(fmt::format("{}", simulated[i].total_collisions));
    }
    row.push_back(fmt::format("{:.4f}{}", front.members[i].fitness, picked == i ? " <" : "  "));
    rows.push_back(std::move(row));
  }
  rows[0].back() += "  ";
  std::string text;
  for (const std::vector<std::string>& row : rows) {
    std::string line;
    for (std::size_t column = 0; column < row.size(); ++column) {
      std::size_t width = 0;
      for (const std::vector<std::string>& other : rows) {
        width = std::max(width, other[column].size());
      }
      line += fmt::format("{:>{}}", row[column], width + (column == 0 ? 0 : kGap));
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

std::string to_json(const Front& front, const Vocabulary& vocabulary, std::optional<std::size_t> picked,
                    const std::vector<ControllerScore>& simulated) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < front.members.size(); ++i) {
    const FrontMember& member = front.members[i];
    nlohmann::ordered_json json = {{"number", i}, {"picked", picked == i}, {"fitness", member.fitness}};
    for (std::size_t m = 0; m < front.measures.size(); ++m) {
      json[std::string(name_of(front.measures[m]))] = member.values[m];
    }
    if (!simulated.empty()) {
      const auto mean = [](const Estimate& estimate) {
        return nlohmann::ordered_json{{"mean", estimate.mean}, {"margin", estimate.margin}};
      };
      const ControllerScore& score = simulated[i];
      json["simulated"] = {{"episodes", score.episodes},
                           {"agreement", mean(score.agreement)},
                           {"reward", mean(score.reward)},
                           {"collisions", mean(score.collisions)},
                           {"total_collisions", score.total_collisions},
                           {"unknown_steps", score.unknown_steps}};
    }
    json["tree"] = to_text(member.tree, vocabulary);
    list.push_back(std::move(json));
  }
  return json_line(list);
}

}  // namespace coppice
