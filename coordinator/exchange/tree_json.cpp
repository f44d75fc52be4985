#include "coordinator/exchange/tree_json.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/tree/text.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

Json json_number(const Feature& feature, std::uint8_t value) {
  if (feature.scale == Scale::plain) {
    return value;
  }
  const std::string text = feature.number_text(value);
  return text == "inf" ? Json(text) : Json::parse(text);
}

Json features_of(const ExportedTree& exported) {
  Json features = Json::array();
  for (std::size_t f = 0; f < exported.vocabulary.features.size(); ++f) {
    const Feature& feature = exported.vocabulary.features[f];
    const FeatureLegend& legend = exported.problem.features[f];
    Json json = {{"name", feature.name}, {"label", legend.label}, {"unit", legend.unit}};
    if (feature.scale == Scale::bins) {
      json["bins"] = feature.numbers;
    } else {
      json["values"] = Json::array();
      for (const std::uint8_t value : feature.values) {
        json["values"].push_back(json_number(feature, value));
      }
    }
    for (const auto& [value, label] : legend.values) {
      json["value_labels"][feature.number_text(value)] = label;
    }
    features.push_back(std::move(json));
  }
  return features;
}

// As deep as the tree: kMaxTreeDepth.
Json node_json(const ExportedTree& exported, std::size_t i) {
  const Node& node = exported.tree[i];
  Json json;
  switch (node.kind) {
    case NodeKind::condition: {
      const Feature& feature = exported.vocabulary.features[node.index];
      json = {{"type", "condition"},
              {"feature", feature.name},
              {"op", node.op == Op::equal ? "=" : "<="},
              {"value", json_number(feature, node.value)}};
      break;
    }
    case NodeKind::action:
      json = {{"type", "action"}, {"action", exported.vocabulary.actions[node.index]}};
      break;
    case NodeKind::sequence:
    case NodeKind::selector:
      json = {{"type", node.kind == NodeKind::sequence ? "sequence" : "selector"}, {"children", Json::array()}};
      for (std::size_t child = i + 1; child < i + node.extent; child += exported.tree[child].extent) {
        json["children"].push_back(node_json(exported, child));
      }
      return json;
  }
  if (const std::string words = in_words(node, exported.problem, exported.vocabulary); !words.empty()) {
    json["words"] = words;
  }
  return json;
}

class JsonReader {
 public:
  explicit JsonReader(const Vocabulary& vocabulary) : vocabulary_(vocabulary) {}

  // As deep as a tree may be, and one.
  Result<void> read(const Json& json, const std::string& where, std::size_t depth) {
    if (nodes_.size() >= kMaxTreeNodes || depth > kMaxTreeDepth) {
      return bad_input(fmt::format("{}: one more node: expected at most {} nodes and {} edges from the root", where,
                                   kMaxTreeNodes, kMaxTreeDepth));
    }
    if (!json.is_object()) {
      return bad_input(fmt::format("{}: found {}: expected a node, as an object", where, json.type_name()));
    }
    const std::string type = text_of(json, "type");
    if (type == "sequence" || type == "selector") {
      return composite(json, where, depth, type == "sequence" ? NodeKind::sequence : NodeKind::selector);
    }
    if (type == "condition") {
      return condition(json, where);
    }
    if (type == "action") {
      const std::optional<ActionId> action = vocabulary_.find_action(text_of(json, "action"));
      if (!action) {
        return bad_input(fmt::format("{}.action: found {}: expected one of {}", where, found(json, "action"),
                                     fmt::join(vocabulary_.actions, ", ")));
      }
      nodes_.push_back(Node::action(*action));
      return {};
    }
    return bad_input(
        fmt::format("{}.type: found {}: expected sequence, selector, condition or action", where, found(json, "type")));
  }

  std::vector<Node> take() && { return std::move(nodes_); }

 private:
  static constexpr std::size_t kMaxQuoted = 64;

  // Empty: there is no such text.
  static std::string text_of(const Json& json, const char* key) {
    const auto place = json.find(key);
    return place != json.end() && place->is_string() ? place->get<std::string>() : std::string();
  }

  static std::string found(const Json& json, const char* key) {
    const auto place = json.find(key);
    if (place == json.end()) {
      return "nothing";
    }
    return one_line(place->dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, kMaxQuoted));
  }

  Result<void> composite(const Json& json, const std::string& where, std::size_t depth, NodeKind kind) {
    const auto children = json.find("children");
    if (children == json.end() || !children->is_array() || children->empty()) {
      return bad_input(
          fmt::format("{}.children: found {}: expected a list of one node or more", where, found(json, "children")));
    }
    const std::size_t at = nodes_.size();
    nodes_.push_back(Node::composite(kind, 0));
    for (std::size_t i = 0; i < children->size(); ++i) {
      if (auto ok = read((*children)[i], fmt::format("{}.children[{}]", where, i), depth + 1); !ok) {
        return ok;
      }
    }
    nodes_[at].extent = static_cast<std::uint16_t>(nodes_.size() - at);
    return {};
  }

  Result<void> condition(const Json& json, const std::string& where) {
    const std::optional<std::size_t> index = vocabulary_.find_feature(text_of(json, "feature"));
    if (!index) {
      return bad_input(fmt::format("{}.feature: found {}: expected one of {}", where, found(json, "feature"),
                                   fmt::join(feature_names(vocabulary_), ", ")));
    }
    const Feature& feature = vocabulary_.features[*index];
    const std::string op = text_of(json, "op");
    const bool known = (op == "=" && feature.admits_equal) || (op == "<=" && feature.admits_less_equal);
    if (!known) {
      return bad_input(fmt::format("{}.op: found {}: expected {}", where, found(json, "op"),
                                   feature.admits_equal && feature.admits_less_equal ? "= or <="
                                   : feature.admits_equal                            ? "="
                                                                                     : "<="));
    }
    const auto value = json.find("value");
    std::optional<std::uint8_t> code;
    if (value != json.end() && (value->is_number() || value->is_string())) {
      code = feature.value_of_text(value->is_string() ? value->get<std::string>() : value->dump());
    }
    if (!code) {
      return bad_input(fmt::format("{}.value: found {}: expected a value of '{}': one of {}", where,
                                   found(json, "value"), feature.name, feature.values_text()));
    }
    nodes_.push_back(Node::condition(*index, op == "=" ? Op::equal : Op::less_equal, *code));
    return {};
  }

  const Vocabulary& vocabulary_;
  std::vector<Node> nodes_;
};

}  // namespace

std::string to_tree_json(const ExportedTree& exported) {
  Json actions = Json::array();
  for (std::size_t a = 0; a < exported.vocabulary.actions.size(); ++a) {
    actions.push_back({{"name", exported.vocabulary.actions[a]}, {"label", exported.problem.action_labels[a]}});
  }
  const Json json = {{"format", "coppice-tree-1"},        {"origin", exported.origin},
                     {"nodes", exported.tree.size()},     {"text", to_text(exported.tree, exported.vocabulary)},
                     {"features", features_of(exported)}, {"actions", actions},
                     {"tree", node_json(exported, 0)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

Result<Tree> parse_tree_json(std::string_view text, const std::string& name, const Vocabulary& vocabulary) {
  if (text.size() > kMaxTreeJson) {
    return bad_input(fmt::format("{}: {} characters: expected at most {}", name, text.size(), kMaxTreeJson));
  }
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object()) {
    return bad_input(fmt::format("{}: not a JSON object: expected a tree as coppice exports it", name));
  }
  const auto inside = json.find("tree");
  JsonReader reader(vocabulary);
  const Result<void> read = inside != json.end() ? reader.read(*inside, "tree", 0) : reader.read(json, "tree", 0);
  if (!read) {
    return in_context(name, read.error());
  }
  Result<Tree> tree = Tree::from_nodes(std::move(reader).take());
  if (!tree) {
    return in_context(name, std::move(tree).error());
  }
  return tree;
}

}  // namespace coppice
