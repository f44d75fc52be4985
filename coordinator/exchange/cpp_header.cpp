#include "coordinator/exchange/cpp_header.hpp"

#include <fmt/format.h>

#include "common/tree/text.hpp"
#include "coordinator/exchange/guarded_code.hpp"

namespace coppice {
namespace {

// [lex.key], [lex.digraph] of C++17, the words that C++20 added, and the names that the header itself uses; macros of
// <cmath> and <windows.h> that have bitten enumerators.
const std::set<std::string> reserved_words = {
    "alignas",     "alignof",   "and",        "and_eq",      "asm",      "auto",         "bitand",
    "bitor",       "bool",      "break",      "case",        "catch",    "char",         "char8_t",
    "char16_t",    "char32_t",  "class",      "compl",       "concept",  "const",        "consteval",
    "constexpr",   "constinit", "const_cast", "continue",    "co_await", "co_return",    "co_yield",
    "decltype",    "default",   "delete",     "do",          "double",   "dynamic_cast", "else",
    "enum",        "explicit",  "export",     "extern",      "false",    "float",        "for",
    "friend",      "goto",      "if",         "inline",      "int",      "long",         "mutable",
    "namespace",   "new",       "noexcept",   "not",         "not_eq",   "nullptr",      "operator",
    "or",          "or_eq",     "private",    "protected",   "public",   "register",     "reinterpret_cast",
    "requires",    "return",    "short",      "signed",      "sizeof",   "static",       "static_assert",
    "static_cast", "struct",    "switch",     "template",    "this",     "thread_local", "throw",
    "true",        "try",       "typedef",    "typeid",      "typename", "union",        "unsigned",
    "using",       "virtual",   "void",       "volatile",    "wchar_t",  "while",        "xor",
    "xor_eq",      "none",      "Action",     "Observation", "NULL",     "NAN",          "INFINITY",
    "ERROR",       "IN",        "OUT",        "DELETE",      "assert",   "errno",        "EOF"};

// Names with two underscores in a row, or one before a capital, belong to the implementation ([lex.name]).
std::vector<std::string> cpp_names(const std::vector<std::string>& names) {
  std::vector<std::string> mine;
  std::set<std::string> reserved = reserved_words;
  for (const std::string& name : names) {
    std::string allowed;
    for (const char c : name) {
      if (c != '_' || (!allowed.empty() && allowed.back() != '_')) {
        allowed += c;
      }
    }
    mine.push_back(allowed.empty() || (allowed.front() >= '0' && allowed.front() <= '9') ? "v" + allowed : allowed);
  }
  // Names that became alike are told apart by a number.
  std::set<std::string> seen;
  for (std::string& name : mine) {
    const std::string stem = name;
    for (std::size_t number = 2; !seen.insert(name).second; ++number) {
      name = fmt::format("{}{}", stem, number);
    }
  }
  return identifiers(mine, reserved);
}

}  // namespace

std::string to_cpp_header(const ExportedTree& exported) {
  const Vocabulary& vocabulary = exported.vocabulary;
  const std::vector<std::string> features = cpp_names(feature_names(vocabulary));
  const std::vector<std::string> actions = cpp_names(vocabulary.actions);
  std::string text;
  for (const std::string& line : header_lines(exported)) {
    text += "// " + line + '\n';
  }
  text +=
      "// Written by coppice. C++17, no dependencies; any thread. policy::action(observation) gives the action, or "
      "Action::none.\n"
      "#pragma once\n\n"
      "namespace policy {\n\n"
      "enum class Action {\n";
  for (const std::string& action : actions) {
    text += fmt::format("  {},\n", action);
  }
  text +=
      "  none  // the tree does not act\n"
      "};\n\n"
      "// What is observed, each in its own unit.\n"
      "struct Observation {\n";
  for (std::size_t f = 0; f < features.size(); ++f) {
    const FeatureLegend& legend = exported.problem.features[f];
    std::string note = legend.label + (legend.unit.empty() ? "" : " [" + legend.unit + "]");
    text += fmt::format("  double {} = 0;{}\n", features[f], note.empty() ? "" : "  // " + one_line(note));
  }
  text +=
      "};\n\n"
      "constexpr Action action([[maybe_unused]] const Observation& o) noexcept {\n";
  text += guarded_code(exported.tree,
                       {.all = " && ",
                        .any = " || ",
                        .indent = "  ",
                        .condition =
                            [&](const Node& node) {
                              return fmt::format("o.{} {} {}", features[node.index], node.op == Op::equal ? "==" : "<=",
                                                 compared_number(vocabulary.features[node.index], node.value));
                            },
                        .open_if = [](const std::string& tests) { return "if (" + tests + ") {"; },
                        .close_if = "}",
                        .result =
                            [&](ActionId action) {
                              return fmt::format("return Action::{};",
                                                 action == kNoAction ? "none" : actions[index_of(action)]);
                            }},
                       1);
  text +=
      "}\n\n"
      "// The action's name as the study has it; \"\" for none.\n"
      "constexpr const char* name_of(Action action) noexcept {\n"
      "  switch (action) {\n";
  for (std::size_t a = 0; a < actions.size(); ++a) {
    text += fmt::format("    case Action::{}: return \"{}\";\n", actions[a], vocabulary.actions[a]);
  }
  return text +
         "    case Action::none: break;\n"
         "  }\n"
         "  return \"\";\n"
         "}\n\n"
         "}  // namespace policy\n";
}

}  // namespace coppice
