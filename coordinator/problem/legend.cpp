#include "coordinator/problem/legend.hpp"

#include <fmt/format.h>

namespace coppice {

std::string feature_legend(std::size_t feature, const Problem& problem, const Vocabulary& vocabulary) {
  const Feature& declared = vocabulary.features[feature];
  const FeatureLegend& legend = problem.features[feature];
  std::string line = legend.label;
  if (!legend.unit.empty()) {
    line += fmt::format("{}[{}]", line.empty() ? "" : " ", legend.unit);
  }
  std::string values;
  for (const auto& [value, label] : legend.values) {
    values += fmt::format("{}{} {}", values.empty() ? "" : ", ", declared.number_text(value), label);
  }
  if (!values.empty()) {
    line += fmt::format("{}({})", line.empty() ? "" : " ", values);
  }
  return line.empty() ? line : declared.name + ": " + line;
}

std::string action_legend(std::size_t action, const Problem& problem, const Vocabulary& vocabulary) {
  const std::string& label = problem.action_labels[action];
  return label.empty() ? label : vocabulary.actions[action] + ": " + label;
}

std::vector<std::string> legend_lines(const Tree& tree, const Problem& problem, const Vocabulary& vocabulary) {
  std::vector<bool> features(vocabulary.features.size(), false);
  std::vector<bool> actions(vocabulary.actions.size(), false);
  for (const Node& node : tree.nodes()) {
    if (node.is_leaf()) {
      (node.kind == NodeKind::condition ? features : actions)[node.index] = true;
    }
  }
  std::vector<std::string> lines;
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (std::string line = features[f] ? feature_legend(f, problem, vocabulary) : std::string(); !line.empty()) {
      lines.push_back(std::move(line));
    }
  }
  for (std::size_t a = 0; a < actions.size(); ++a) {
    if (std::string line = actions[a] ? action_legend(a, problem, vocabulary) : std::string(); !line.empty()) {
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

}  // namespace coppice
