#include "coordinator/report/state_table.hpp"

#include <fmt/format.h>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "common/tree/action_table.hpp"
#include "common/tree/state_columns.hpp"

namespace coppice {
namespace {

// RFC 4180, section 2, rules 5 to 7.
std::string csv_field(std::string_view text) {
  if (text.find_first_of("\",\r\n") == std::string_view::npos) {
    return std::string(text);
  }
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c;
    if (c == '"') {
      quoted += '"';
    }
  }
  return quoted + '"';
}

}  // namespace

void write_state_table(const Chain& chain, const Tree& tree, std::ostream& out) {
  const Vocabulary& vocabulary = chain.vocabulary();
  for (const Feature& feature : vocabulary.features) {
    out << csv_field(feature.name) << ',';
  }
  out << "visits,policy_action,tree_action\n";

  std::vector<std::string> action_fields;
  action_fields.reserve(vocabulary.actions.size());
  for (const std::string& action : vocabulary.actions) {
    action_fields.push_back(csv_field(action));
  }
  const StateColumns columns(vocabulary, chain.parts().features);
  const std::vector<ActionId> table = action_table(tree, columns);
  std::string line;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    line.clear();
    for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
      line += vocabulary.features[f].number_text(chain.features_of(state)[f]);
      line += ',';
    }
    const std::string_view tree_action =
        table[state] == kNoAction ? std::string_view() : std::string_view(action_fields[index_of(table[state])]);
    fmt::format_to(std::back_inserter(line), "{},{},{}\n", chain.parts().visits[state],
                   action_fields[index_of(chain.policy(state))], tree_action);
    out << line;
  }
}

}  // namespace coppice
