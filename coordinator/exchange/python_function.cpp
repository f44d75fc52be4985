#include "coordinator/exchange/python_function.hpp"

#include <fmt/format.h>

#include "coordinator/exchange/guarded_code.hpp"

namespace coppice {

std::string to_python_function(const ExportedTree& exported) {
  std::string text;
  for (const std::string& line : header_lines(exported)) {
    text += "# " + line + '\n';
  }
  text +=
      "\"\"\"A policy that coppice wrote.\"\"\"\n\n\n"
      "def action(observation):\n"
      "    \"\"\"The action's name, or None where the tree does not act.\n\n"
      "    observation: a mapping from feature names to values, each in its own unit.\n"
      "    \"\"\"\n"
      "    o = observation\n";
  text += guarded_code(
      exported.tree,
      {.all = " and ",
       .any = " or ",
       .indent = "    ",
       .condition =
           [&](const Node& node) {
             const Feature& feature = exported.vocabulary.features[node.index];
             return fmt::format("o[\"{}\"] {} {}", feature.name,
                                node.op == Op::equal ? "==" : "<=", compared_number(feature, node.value));
           },
       .open_if = [](const std::string& tests) { return "if " + tests + ":"; },
       .close_if = "",
       .result =
           [&](ActionId action) {
             return action == kNoAction ? std::string("return None")
                                        : fmt::format("return \"{}\"", exported.vocabulary.actions[index_of(action)]);
           }},
      1);
  return text;
}

}  // namespace coppice
