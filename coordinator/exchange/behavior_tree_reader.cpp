#include "coordinator/exchange/behavior_tree_reader.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <fmt/format.h>
#include <optional>
#include <tinyxml2.h>
#include <vector>

#include "coordinator/exchange/behavior_tree_names.hpp"
#include "coordinator/exchange/exported_tree.hpp"

namespace coppice {
namespace {

using tinyxml2::XMLAttribute;
using tinyxml2::XMLElement;

constexpr std::size_t kMaxQuotedXml = 64;  // characters of the input repeated in a message

std::string quoted_xml(std::string_view text) {
  return '\'' + one_line(text.substr(0, kMaxQuotedXml)) + (text.size() > kMaxQuotedXml ? "...'" : "'");
}

std::string_view attribute(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value == nullptr ? std::string_view() : std::string_view(value);
}

// "s3 == 0" in its three parts; blanks between them do not count.
struct Script {
  std::string_view left;
  std::string_view op;
  std::string_view right;
};

std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && is_blank(text.front())) {
    text.remove_prefix(1);
  }
  while (!text.empty() && is_blank(text.back())) {
    text.remove_suffix(1);
  }
  return text;
}

std::optional<Script> script_of(std::string_view code, std::string_view op) {
  const std::size_t at = code.find(op);
  if (at == std::string_view::npos) {
    return std::nullopt;
  }
  return Script{trimmed(code.substr(0, at)), op, trimmed(code.substr(at + op.size()))};
}

class XmlReader {
 public:
  XmlReader(std::string name, const Vocabulary& vocabulary)
      : name_(std::move(name)),
        vocabulary_(vocabulary),
        entries_(entry_names(vocabulary)),
        ids_(node_ids(vocabulary)) {}

  Result<Tree> read(std::string_view xml) {
    if (xml.size() > kMaxBehaviorTreeXml) {
      return bad_input(fmt::format("{}: {} characters: expected at most {}", name_, xml.size(), kMaxBehaviorTreeXml));
    }
    tinyxml2::XMLDocument document;
    if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS) {
      return bad_input(fmt::format("{}: line {}: not well-formed XML ({})", name_, document.ErrorLineNum(),
                                   tinyxml2::XMLDocument::ErrorIDToName(document.ErrorID())));
    }
    root_ = document.RootElement();
    if (root_ == nullptr || root_->Name() != std::string_view("root")) {
      return bad_input(fmt::format("{}: the outermost element is {}: expected <root>", name_,
                                   root_ == nullptr ? "missing" : quoted_xml(root_->Name())));
    }
    if (attribute(*root_, "BTCPP_format") != "4") {
      return wrong(*root_, fmt::format("BTCPP_format {}", quoted_xml(attribute(*root_, "BTCPP_format"))),
                   "\"4\", BehaviorTree.CPP 4");
    }
    if (const XMLElement* include = root_->FirstChildElement("include"); include != nullptr) {
      return wrong(*include, "an <include>", "one file");
    }
    const XMLElement* tree = main_tree();
    if (tree == nullptr) {
      const std::string_view wanted = attribute(*root_, "main_tree_to_execute");
      return wrong(*root_,
                   wanted.empty() ? std::string("no main_tree_to_execute, and not exactly one <BehaviorTree>")
                                  : fmt::format("no <BehaviorTree> with the ID {}", quoted_xml(wanted)),
                   "the main tree");
    }
    if (Result<void> done = behavior_tree(*tree); !done) {
      return tl::unexpected(std::move(done).error());
    }
    Result<Tree> result = Tree::from_nodes(std::move(nodes_));
    if (!result) {
      return in_context(name_, std::move(result).error());
    }
    return result;
  }

 private:
  tl::unexpected<Error> wrong(const XMLElement& element, const std::string& found, const std::string& expected) const {
    return bad_input(fmt::format("{}: line {}: found {}: expected {}", name_, element.GetLineNum(), found, expected));
  }

  const XMLElement* tree_of_id(std::string_view id) const {
    for (const XMLElement* tree = root_->FirstChildElement("BehaviorTree"); tree != nullptr;
         tree = tree->NextSiblingElement("BehaviorTree")) {
      if (attribute(*tree, "ID") == id) {
        return tree;
      }
    }
    return nullptr;
  }

  const XMLElement* main_tree() const {
    if (const std::string_view wanted = attribute(*root_, "main_tree_to_execute"); !wanted.empty()) {
      return tree_of_id(wanted);
    }
    const XMLElement* first = root_->FirstChildElement("BehaviorTree");
    return first != nullptr && first->NextSiblingElement("BehaviorTree") == nullptr ? first : nullptr;
  }

  Result<void> behavior_tree(const XMLElement& tree) {
    const XMLElement* child = tree.FirstChildElement();
    if (child == nullptr || child->NextSiblingElement() != nullptr) {
      return wrong(tree, child == nullptr ? "an empty <BehaviorTree>" : "a <BehaviorTree> with several children",
                   "exactly one");
    }
    return node(*child);
  }

  // `allowed`: besides name, ID and what Groot2 keeps for itself.
  Result<void> check_attributes(const XMLElement& element, std::string_view allowed) const {
    for (const XMLAttribute* each = element.FirstAttribute(); each != nullptr; each = each->Next()) {
      const std::string_view key = each->Name();
      const bool known = key == "name" || key == "ID" || key == "_uid" || key == "_fullpath" || key == "_description" ||
                         (!allowed.empty() && key == allowed);
      if (!known) {
        return wrong(
            element, fmt::format("attribute {} of <{}>", quoted_xml(key), one_line(element.Name())),
            "a node without pre- or postconditions and without ports of its own: that has no counterpart here");
      }
    }
    return {};
  }

  Result<void> node(const XMLElement& element) {
    if (nodes_.size() >= kMaxTreeNodes) {
      return wrong(element, "one more node", fmt::format("at most {} nodes in a tree", kMaxTreeNodes));
    }
    const std::string_view tag = element.Name();
    if (tag == "Sequence" || tag == "ReactiveSequence") {
      return composite(element, NodeKind::sequence);
    }
    if (tag == "Fallback" || tag == "ReactiveFallback") {
      return composite(element, NodeKind::selector);
    }
    if (tag == "ScriptCondition" || tag == "Script") {
      if (Result<void> known = check_attributes(element, "code"); !known) {
        return known;
      }
      return tag == "Script" ? assignment(element) : comparison(element);
    }
    if (tag == "SubTree") {
      return subtree(element);
    }
    if (Result<void> known = check_attributes(element, ""); !known) {
      return known;
    }
    return registered(element, tag == "Action" || tag == "Condition" ? attribute(element, "ID") : tag);
  }

  Result<void> composite(const XMLElement& element, NodeKind kind) {
    if (Result<void> known = check_attributes(element, ""); !known) {
      return known;
    }
    if (depth_ >= kMaxTreeDepth) {
      return wrong(element, "a deeper node", fmt::format("at most {} edges from the root", kMaxTreeDepth));
    }
    if (element.FirstChildElement() == nullptr) {
      return wrong(element, fmt::format("<{}> without children", element.Name()), "one or more");
    }
    const std::size_t at = nodes_.size();
    nodes_.push_back(Node::composite(kind, 0));
    ++depth_;
    for (const XMLElement* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
      if (Result<void> done = node(*child); !done) {
        return done;
      }
    }
    --depth_;
    nodes_[at].extent = static_cast<std::uint16_t>(nodes_.size() - at);
    return {};
  }

  // Written out in place; a tree that contains itself is found by the depth of the calls.
  Result<void> subtree(const XMLElement& element) {
    constexpr std::size_t kMaxCalls = 64;
    if (Result<void> known = check_attributes(element, "_autoremap"); !known) {
      return known;
    }
    const XMLElement* called = tree_of_id(attribute(element, "ID"));
    if (called == nullptr) {
      return wrong(element, fmt::format("a SubTree with the ID {}", quoted_xml(attribute(element, "ID"))),
                   "the ID of a <BehaviorTree> of this file");
    }
    if (calls_ >= kMaxCalls) {
      return wrong(element, "a SubTree inside itself", fmt::format("at most {} within one another", kMaxCalls));
    }
    ++calls_;
    Result<void> done = behavior_tree(*called);
    --calls_;
    return done;
  }

  Result<void> comparison(const XMLElement& element) {
    const std::string_view code = attribute(element, "code");
    const auto expected = [this] {
      return fmt::format("a feature ({}), == or <=, and one of its values; one comparison a node",
                         fmt::join(entries_, ", "));
    };
    std::optional<Script> script = script_of(code, "<=");
    const Op op = script ? Op::less_equal : Op::equal;
    if (!script) {
      script = script_of(code, "==");
    }
    if (!script) {
      return wrong(element, "the script " + quoted_xml(code), expected());
    }
    const auto entry = std::find(entries_.begin(), entries_.end(), script->left);
    if (entry == entries_.end()) {
      return wrong(element, "the script " + quoted_xml(code), expected());
    }
    const auto index = static_cast<std::size_t>(entry - entries_.begin());
    const Feature& feature = vocabulary_.features[index];
    if (!feature.admits(op)) {
      return wrong(element, "the script " + quoted_xml(code),
                   fmt::format("{} after '{}'", op == Op::equal ? "<=" : "==", feature.name));
    }
    for (const std::uint8_t value : feature.values) {
      if (compared_number(feature, value) == script->right) {
        nodes_.push_back(Node::condition(index, op, value));
        return {};
      }
    }
    const std::optional<std::uint8_t> value = feature.value_of_text(script->right);
    if (!value) {
      return wrong(element, "the script " + quoted_xml(code),
                   fmt::format("a value of '{}': one of {}", feature.name, feature.values_text()));
    }
    nodes_.push_back(Node::condition(index, op, *value));
    return {};
  }

  Result<void> assignment(const XMLElement& element) {
    const std::string_view code = attribute(element, "code");
    std::optional<Script> script = script_of(code, ":=");
    if (!script) {
      script = script_of(code, "=");
    }
    if (script && script->left == kActionEntry) {
      for (std::size_t a = 0; a < vocabulary_.actions.size(); ++a) {
        if (script->right == fmt::format("{}", a) || script->right == vocabulary_.actions[a]) {
          nodes_.push_back(Node::action(ActionId{static_cast<std::uint8_t>(a)}));
          return {};
        }
      }
    }
    return wrong(element, "the script " + quoted_xml(code),
                 fmt::format("{} := an action, 0 to {} or its name", kActionEntry, vocabulary_.actions.size() - 1));
  }

  Result<void> registered(const XMLElement& element, std::string_view id) {
    if (ids_) {
      if (const auto condition = ids_->conditions.find(std::string(id)); condition != ids_->conditions.end()) {
        nodes_.push_back(condition->second);
        return {};
      }
      const auto action = std::find(ids_->actions.begin(), ids_->actions.end(), id);
      if (action != ids_->actions.end()) {
        nodes_.push_back(Node::action(ActionId{static_cast<std::uint8_t>(action - ids_->actions.begin())}));
        return {};
      }
    }
    const std::string example =
        ids_ && !ids_->conditions.empty() ? fmt::format(" like {}", ids_->conditions.begin()->first) : "";
    return wrong(element, "a node " + quoted_xml(id),
                 fmt::format("Sequence, Fallback, ScriptCondition, Script, SubTree, an action ({}) or a condition{}: "
                             "others have no counterpart here",
                             fmt::join(vocabulary_.actions, ", "), example));
  }

  std::string name_;
  const Vocabulary& vocabulary_;
  std::vector<std::string> entries_;
  Result<NodeIds> ids_;
  const XMLElement* root_ = nullptr;
  std::vector<Node> nodes_;
  std::size_t depth_ = 0;
  std::size_t calls_ = 0;
};

}  // namespace

Result<Tree> parse_behavior_tree_xml(std::string_view xml, const std::string& name, const Vocabulary& vocabulary) {
  return XmlReader(name, vocabulary).read(xml);
}

}  // namespace coppice
