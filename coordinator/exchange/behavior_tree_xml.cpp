#include "coordinator/exchange/behavior_tree_xml.hpp"

#include <fmt/format.h>
#include <limits>
#include <set>

#include "common/check.hpp"
#include "common/tree/guard.hpp"
#include "common/tree/text.hpp"
#include "coordinator/exchange/behavior_tree_names.hpp"

namespace coppice {
namespace {

std::string xml_text(std::string_view text) {
  std::string escaped;
  for (const char c : one_line(text)) {
    switch (c) {
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '&':
        escaped += "&amp;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

// A comment must not hold "--", nor end in '-'.
std::string comment_text(std::string_view text) {
  std::string safe;
  for (const char c : one_line(text)) {
    safe += c == '-' && !safe.empty() && safe.back() == '-' ? '~' : c;
  }
  return safe;
}

class XmlWriter {
 public:
  XmlWriter(const ExportedTree& exported, BehaviorTreeStyle style, std::vector<std::string> names)
      : exported_(exported), style_(style), names_(std::move(names)) {}

  std::string write() {
    text_ = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    text_ += "<!-- " + comment_text(introduction()) + "\n";
    for (const std::string& line : header_lines(exported_)) {
      text_ += "     " + comment_text(line) + '\n';
    }
    if (style_ == BehaviorTreeStyle::scripts) {
      for (std::size_t a = 0; a < exported_.vocabulary.actions.size(); ++a) {
        text_ += fmt::format("     action {} is {}\n", a, exported_.vocabulary.actions[a]);
      }
    }
    text_ +=
        "-->\n<root BTCPP_format=\"4\" main_tree_to_execute=\"Policy\">\n"
        "  <BehaviorTree ID=\"Policy\">\n";
    nodes();
    text_ += "  </BehaviorTree>\n";
    if (style_ == BehaviorTreeStyle::nodes) {
      model();
    }
    return text_ + "</root>\n";
  }

 private:
  std::string introduction() const {
    return style_ == BehaviorTreeStyle::scripts
               ? "Written by coppice for BehaviorTree.CPP 4. Before each tick set every feature on the root blackboard "
                 "and action to -1; read action after it."
               : "Written by coppice for BehaviorTree.CPP 4. Register a node for every ID of the TreeNodesModel below.";
  }

  std::string named(const Node& node) const {
    const std::string words = in_words(node, exported_.problem, exported_.vocabulary);
    const std::string text = to_text(node, exported_.vocabulary);
    return xml_text(words.empty() ? text : fmt::format("{} ({})", words, text));
  }

  std::string leaf(const Node& node) const {
    const bool asks = node.kind == NodeKind::condition;
    if (style_ == BehaviorTreeStyle::nodes) {
      return asks ? fmt::format("<Condition ID=\"{}\" name=\"{}\"/>", condition_id(node, exported_.vocabulary),
                                named(node))
                  : fmt::format("<Action ID=\"{}\" name=\"{}\"/>", names_[node.index], named(node));
    }
    if (asks) {
      return fmt::format("<ScriptCondition code=\"{} {} {}\" name=\"{}\"/>", names_[node.index],
                         node.op == Op::equal ? "==" : "&lt;=",
                         compared_number(exported_.vocabulary.features[node.index], node.value), named(node));
    }
    return fmt::format("<Script code=\"{} := {}\" name=\"{}\"/>", kActionEntry, node.index, named(node));
  }

  void line(std::size_t level, std::string_view content) {
    text_ += std::string(2 * level, ' ');
    text_ += content;
    text_ += '\n';
  }

  void nodes() {
    struct Open {
      std::size_t end;
      const char* tag;
    };
    constexpr std::size_t kLevel = 2;  // of the root inside BehaviorTree
    std::vector<Open> open;
    const Tree& tree = exported_.tree;
    for (std::size_t i = 0; i < tree.size(); ++i) {
      if (tree[i].is_composite()) {
        const char* tag = tree[i].kind == NodeKind::sequence ? "Sequence" : "Fallback";
        line(kLevel + open.size(), fmt::format("<{}>", tag));
        open.push_back({i + tree[i].extent, tag});
        continue;
      }
      line(kLevel + open.size(), leaf(tree[i]));
      while (!open.empty() && open.back().end == i + 1) {
        const char* tag = open.back().tag;
        open.pop_back();
        line(kLevel + open.size(), fmt::format("</{}>", tag));
      }
    }
  }

  void model() {
    std::set<std::string> declared;
    line(1, "<TreeNodesModel>");
    for (const Node& node : exported_.tree.nodes()) {
      if (node.is_leaf()) {
        const bool asks = node.kind == NodeKind::condition;
        const std::string id = asks ? condition_id(node, exported_.vocabulary) : names_[node.index];
        if (declared.insert(id).second) {
          line(2, fmt::format("<{} ID=\"{}\"/>", asks ? "Condition" : "Action", id));
        }
      }
    }
    line(1, "</TreeNodesModel>");
  }

  const ExportedTree& exported_;
  BehaviorTreeStyle style_;
  std::vector<std::string> names_;  // scripts: entries of features; nodes: IDs of actions
  std::string text_;
};

// scripting/operators.hpp: numbers are equal when they differ by less than the epsilon of float.
Result<void> check_told_apart(const ExportedTree& exported) {
  for (const Node& node : exported.tree.nodes()) {
    if (node.kind != NodeKind::condition || node.op != Op::equal) {
      continue;
    }
    const Feature& feature = exported.vocabulary.features[node.index];
    for (std::size_t i = 1; feature.scale == Scale::numbers && i < feature.numbers.size(); ++i) {
      if (feature.numbers[i] - feature.numbers[i - 1] <= static_cast<double>(std::numeric_limits<float>::epsilon())) {
        return bad_input(
            fmt::format("feature '{}' reads {} and {}: the scripts of BehaviorTree.CPP cannot tell them "
                        "apart: expected numbers at least 1.2e-7 apart",
                        feature.name, feature.numbers[i - 1], feature.numbers[i]));
      }
    }
  }
  return {};
}

}  // namespace

Result<std::string> to_behavior_tree_xml(const ExportedTree& exported, BehaviorTreeStyle style) {
  if (style == BehaviorTreeStyle::scripts) {
    if (const Result<void> apart = check_told_apart(exported); !apart) {
      return tl::unexpected(apart.error());
    }
    return XmlWriter(exported, style, entry_names(exported.vocabulary)).write();
  }
  COPPICE_CHECK(is_guarded(exported.tree));
  Result<NodeIds> ids = node_ids(exported.vocabulary);
  if (!ids) {
    return tl::unexpected(std::move(ids).error());
  }
  return XmlWriter(exported, style, std::move(ids->actions)).write();
}

}  // namespace coppice
