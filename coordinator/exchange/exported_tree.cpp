#include "coordinator/exchange/exported_tree.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/tree/text.hpp"
#include "coordinator/problem/legend.hpp"

namespace coppice {

std::vector<std::string> identifiers(const std::vector<std::string>& names, const std::set<std::string>& reserved) {
  std::set<std::string> taken = reserved;
  // A name that needs no change keeps it, wherever it stands.
  std::set<std::string> unchanged;
  for (const std::string& name : names) {
    if (reserved.count(name) == 0) {
      unchanged.insert(name);
    }
  }
  std::vector<std::string> result;
  for (const std::string& name : names) {
    std::string identifier = name;
    if (reserved.count(name) != 0) {
      do {
        identifier += '_';
      } while (taken.count(identifier) != 0 || unchanged.count(identifier) != 0);
    }
    taken.insert(identifier);
    result.push_back(std::move(identifier));
  }
  return result;
}

std::vector<std::string> feature_names(const Vocabulary& vocabulary) {
  std::vector<std::string> names;
  names.reserve(vocabulary.features.size());
  for (const Feature& feature : vocabulary.features) {
    names.push_back(feature.name);
  }
  return names;
}

std::string compared_number(const Feature& feature, std::uint8_t value) {
  const std::string text = feature.number_text(value);
  return text == "inf" ? "1.7976931348623157e+308" : text;
}

std::string one_line(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool is_control = static_cast<unsigned char>(c) < 0x20U || c == 0x7F;
    line += is_control ? ' ' : (c == '\\' ? '/' : c);
  }
  return line;
}

std::vector<std::string> header_lines(const ExportedTree& exported) {
  std::vector<std::string> lines = {one_line(fmt::format("tree of {}: {} node{}", exported.origin, exported.tree.size(),
                                                         exported.tree.size() == 1 ? "" : "s"))};
  for (const std::string& line : legend_lines(exported.tree, exported.problem, exported.vocabulary)) {
    lines.push_back(one_line(line));
  }
  return lines;
}

}  // namespace coppice
