#include "coordinator/studio/tree_export.hpp"

#include <array>
#include <filesystem>
#include <fmt/format.h>

#include "common/tree/guard.hpp"
#include "common/tree/text.hpp"
#include "coordinator/exchange/behavior_tree_xml.hpp"
#include "coordinator/exchange/cpp_header.hpp"
#include "coordinator/exchange/py_trees_code.hpp"
#include "coordinator/exchange/python_function.hpp"
#include "coordinator/exchange/tikz.hpp"
#include "coordinator/exchange/tree_json.hpp"
#include "coordinator/report/draw.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

struct TreeFormat {
  const char* name;
  const char* extension;
  const char* what;
  bool guarded;  // only a tree that asks before it acts can be written
  Result<std::string> (*write)(const ExportedTree& exported);
};

const std::array<TreeFormat, 9> tree_formats{{
    {"text", ".tree", "one line of text, as every command takes it", false,
     [](const ExportedTree& e) { return Result<std::string>(to_text(e.tree, e.vocabulary) + "\n"); }},
    {"behaviortree", ".xml", "XML of BehaviorTree.CPP 4, scripts", false,
     [](const ExportedTree& e) { return Result<std::string>(to_behavior_tree_xml(e, BehaviorTreeStyle::scripts)); }},
    {"behaviortree-nodes", ".xml", "XML of BehaviorTree.CPP 4, registered nodes", true,
     [](const ExportedTree& e) { return Result<std::string>(to_behavior_tree_xml(e, BehaviorTreeStyle::nodes)); }},
    {"cpp", ".hpp", "a C++17 header", true,
     [](const ExportedTree& e) { return Result<std::string>(to_cpp_header(e)); }},
    {"python", ".py", "a Python function", true,
     [](const ExportedTree& e) { return Result<std::string>(to_python_function(e)); }},
    {"py-trees", ".py", "Python for py_trees", false,
     [](const ExportedTree& e) { return Result<std::string>(to_py_trees_code(e)); }},
    {"json", ".json", "JSON", false, [](const ExportedTree& e) { return Result<std::string>(to_tree_json(e)); }},
    {"dot", ".dot", "a drawing for Graphviz", false,
     [](const ExportedTree& e) { return Result<std::string>(to_dot(e.tree, e.vocabulary, e.problem)); }},
    {"tikz", ".tex", "a drawing for LaTeX", false,
     [](const ExportedTree& e) { return Result<std::string>(to_tikz(e)); }},
}};

}  // namespace

Json export_formats() {
  Json formats = Json::array();
  for (const TreeFormat& format : tree_formats) {
    formats.push_back({{"format", format.name}, {"what", format.what}});
  }
  return formats;
}

Result<Json> export_tree(const Tree& tree, const Study& study, const std::string& format) {
  const Vocabulary& vocabulary = study.chain().vocabulary();
  std::string names;
  for (const TreeFormat& known : tree_formats) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", known.name);
    if (format != known.name) {
      continue;
    }
    const Result<Tree> form = known.guarded ? guard(tree, vocabulary) : Result<Tree>(tree);
    if (!form) {
      return tl::unexpected(form.error());
    }
    const Result<std::string> text =
        known.write({.tree = *form,
                     .vocabulary = vocabulary,
                     .problem = study.problem(),
                     .origin = std::filesystem::path(study.path()).filename().string() + ", studio"});
    return text.map([&](const std::string& written) {
      return Json{{"name", std::string("tree") + known.extension}, {"text", written}};
    });
  }
  return bad_input(fmt::format("there is no format '{}': expected one of {}", format, names));
}

}  // namespace coppice
