#include "coordinator/exchange/tikz.hpp"

#include <fmt/format.h>

#include "common/tree/text.hpp"

namespace coppice {
namespace {

// Text that TeX prints as it is.
std::string tex_text(std::string_view text) {
  std::string escaped;
  for (const char c : one_line(text)) {
    switch (c) {
      case '#':
      case '$':
      case '%':
      case '&':
      case '_':
      case '{':
      case '}':
        escaped += '\\';
        escaped += c;
        break;
      case '~':
        escaped += "\\textasciitilde{}";
        break;
      case '^':
        escaped += "\\textasciicircum{}";
        break;
      case '<':
        escaped += "\\textless{}";
        break;
      case '>':
        escaped += "\\textgreater{}";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string tikz_node(const Node& node, const ExportedTree& exported) {
  if (node.kind == NodeKind::sequence) {
    return "$\\rightarrow$, composite";
  }
  if (node.kind == NodeKind::selector) {
    return "?, composite";
  }
  std::string test = node.kind == NodeKind::action ? tex_text(exported.vocabulary.actions[node.index]) : std::string();
  if (node.kind == NodeKind::condition) {
    const Feature& feature = exported.vocabulary.features[node.index];
    test = fmt::format("{}${}{}$", tex_text(feature.name), node.op == Op::equal ? "=" : "\\le ",
                       node.op == Op::less_equal && feature.number_text(node.value) == "inf"
                           ? "\\infty"
                           : feature.number_text(node.value));
  }
  const std::string words = in_words(node, exported.problem, exported.vocabulary);
  const std::string label = words.empty() ? test : test + "\\\\{\\footnotesize " + tex_text(words) + "}";
  return '{' + label + "}, " + (node.kind == NodeKind::condition ? "condition" : "action");
}

}  // namespace

std::string to_tikz(const ExportedTree& exported) {
  std::string text;
  for (const std::string& line : header_lines(exported)) {
    text += "% " + line + '\n';
  }
  text +=
      "\\documentclass[border=4pt]{standalone}\n"
      "\\usepackage[T1]{fontenc}\n"
      "\\usepackage[utf8]{inputenc}\n"
      "\\usepackage{forest}\n"
      "\\begin{document}\n"
      "\\begin{forest}\n"
      "  for tree={draw, align=center, font=\\small, edge={-stealth}},\n"
      "  composite/.style={minimum size=1.6em, inner sep=2pt},\n"
      "  condition/.style={ellipse, inner sep=1pt},\n"
      "  action/.style={fill=black!8},\n";
  const Tree& tree = exported.tree;
  std::vector<std::size_t> ends;  // of the composites that are open
  for (std::size_t i = 0; i < tree.size(); ++i) {
    text += std::string(2 + 2 * ends.size(), ' ') + '[' + tikz_node(tree[i], exported);
    if (tree[i].is_composite()) {
      ends.push_back(i + tree[i].extent);
    } else {
      text += ']';
    }
    while (!ends.empty() && ends.back() == i + 1) {
      ends.pop_back();
      text += ']';
    }
    text += '\n';
  }
  return text + "\\end{forest}\n\\end{document}\n";
}

}  // namespace coppice
