#include "common/tree/text.hpp"

#include <fmt/format.h>
#include <optional>
#include <vector>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMaxQuoted = 32;  // characters of the input repeated in a message

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_word(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; }

// The text in quotes, foreign characters as \xNN, cut short if it is long.
std::string quoted(std::string_view text) {
  std::string result = "'";
  for (const char c : text.substr(0, kMaxQuoted)) {
    if (c >= ' ' && c <= '~') {
      result += c;
    } else {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    }
  }
  return result + (text.size() > kMaxQuoted ? "...'" : "'");
}

std::string names_of(const Vocabulary& vocabulary) {
  std::vector<std::string_view> features;
  features.reserve(vocabulary.features.size());
  for (const Feature& feature : vocabulary.features) {
    features.emplace_back(feature.name);
  }
  return fmt::format("a feature ({}), an action ({}) or '('", fmt::join(features, ", "),
                     fmt::join(vocabulary.actions, ", "));
}

std::string operators_of(const Feature& feature) {
  if (feature.admits_equal && feature.admits_less_equal) {
    return "'=' or '<='";
  }
  return feature.admits_equal ? "'='" : "'<='";
}

// Reads one node a step, the composites that are still open on a stack, so that no input makes it recurse.
class Parser {
 public:
  Parser(std::string_view text, const Vocabulary& vocabulary) : text_(text), vocabulary_(vocabulary) {}

  Result<Tree> parse() {
    if (text_.size() > kMaxTreeText) {
      return bad_input(fmt::format("tree text has {} characters: expected at most {}", text_.size(), kMaxTreeText));
    }
    do {
      skip_blanks();
      Result<void> read = peek() == ')' ? close() : node();
      if (!read) {
        return tl::unexpected<Error>(std::move(read.error()));
      }
    } while (!open_.empty());
    skip_blanks();
    if (at_ < text_.size()) {
      return wrong(at_, found(), "the end: the tree is complete");
    }
    return Tree::from_nodes(std::move(nodes_));
  }

 private:
  struct Open {
    std::size_t node;
    std::size_t column;
  };

  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) {
      ++at_;
    }
  }
  std::string_view word() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_word(text_[at_])) {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }
  std::string_view number() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_word(text_[at_]) || text_[at_] == '.' || text_[at_] == '-' || text_[at_] == '+')) {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }
  std::string found() const { return at_ < text_.size() ? quoted(text_.substr(at_, 1)) : "the end"; }

  static tl::unexpected<Error> wrong(std::size_t at, const std::string& what, const std::string& expected) {
    return bad_input(fmt::format("column {}: found {}: expected {}", at + 1, what, expected));
  }

  Result<void> node() {
    const std::size_t begin = at_;
    if (nodes_.size() == kMaxTreeNodes) {
      return wrong(begin, "one more node", fmt::format("at most {} nodes in a tree", kMaxTreeNodes));
    }
    if (open_.size() > kMaxTreeDepth) {
      return wrong(begin, "a deeper node", fmt::format("at most {} edges from the root", kMaxTreeDepth));
    }
    return peek() == '(' ? composite() : leaf();
  }

  Result<void> composite() {
    const std::size_t begin = at_;
    ++at_;
    skip_blanks();
    const std::size_t begin_kind = at_;
    const std::string_view kind = word();
    if (kind != "sequence" && kind != "selector") {
      return wrong(begin_kind, kind.empty() ? found() : quoted(kind), "'sequence' or 'selector' after '('");
    }
    open_.push_back({nodes_.size(), begin});
    nodes_.push_back(Node::composite(kind == "sequence" ? NodeKind::sequence : NodeKind::selector, 1));
    return {};
  }

  Result<void> close() {
    if (open_.empty()) {
      return wrong(at_, found(), names_of(vocabulary_));
    }
    Node& node = nodes_[open_.back().node];
    node.extent = static_cast<std::uint16_t>(nodes_.size() - open_.back().node);
    if (node.extent == 1) {
      return wrong(at_, found(),
                   fmt::format("a child of the composite opened at column {}: {}", open_.back().column + 1,
                               names_of(vocabulary_)));
    }
    open_.pop_back();
    ++at_;
    return {};
  }

  Result<void> leaf() {
    const std::size_t begin = at_;
    const std::string_view name = word();
    if (name.empty()) {
      return wrong(begin, found(), open_.empty() ? names_of(vocabulary_) : names_of(vocabulary_) + ", or ')'");
    }
    if (const std::optional<ActionId> action = vocabulary_.find_action(name)) {
      nodes_.push_back(Node::action(*action));
      return separated("after an action");
    }
    if (const std::optional<std::size_t> feature = vocabulary_.find_feature(name)) {
      return condition(*feature);
    }
    return wrong(begin, quoted(name), names_of(vocabulary_));
  }

  Result<void> condition(std::size_t index) {
    const Feature& feature = vocabulary_.features[index];
    const std::size_t begin_op = at_;
    const std::string_view rest = text_.substr(at_);
    Op op = Op::equal;
    if (rest.substr(0, 2) == "<=") {
      op = Op::less_equal;
      at_ += 2;
    } else if (rest.substr(0, 1) == "=") {
      ++at_;
    } else {
      return wrong(begin_op, found(), fmt::format("{} after feature '{}'", operators_of(feature), feature.name));
    }
    if (!feature.admits(op)) {
      return wrong(begin_op, op == Op::equal ? "'='" : "'<='",
                   fmt::format("{} after feature '{}'", operators_of(feature), feature.name));
    }
    const std::size_t begin_value = at_;
    const std::string_view digits = feature.scale == Scale::plain ? word() : number();
    const std::optional<std::uint8_t> value = feature.value_of_text(digits);
    if (!value) {
      return wrong(begin_value, digits.empty() ? found() : quoted(digits),
                   fmt::format("a value of feature '{}': one of {}", feature.name, feature.values_text()));
    }
    nodes_.push_back(Node::condition(index, op, *value));
    return separated("after a condition");
  }

  Result<void> separated(const char* after) {
    if (at_ < text_.size() && !is_blank(text_[at_]) && text_[at_] != '(' && text_[at_] != ')') {
      return wrong(at_, found(), fmt::format("a blank or ')' {}", after));
    }
    return {};
  }

  std::string_view text_;
  const Vocabulary& vocabulary_;
  std::size_t at_ = 0;
  std::vector<Node> nodes_;
  std::vector<Open> open_;
};

}  // namespace

Result<Tree> parse_tree(std::string_view text, const Vocabulary& vocabulary) {
  return Parser(text, vocabulary).parse();
}

std::string to_text(const Tree& tree, const Vocabulary& vocabulary) {
  std::string text;
  std::vector<std::size_t> ends;  // of the composites that are open
  for (std::size_t i = 0; i < tree.size(); ++i) {
    if (i > 0) {
      text += ' ';
    }
    if (tree[i].is_composite()) {
      text += '(';
      ends.push_back(i + tree[i].extent);
    }
    text += to_text(tree[i], vocabulary);
    while (!ends.empty() && ends.back() == i + 1) {
      text += ')';
      ends.pop_back();
    }
  }
  return text;
}

std::string to_text(const Node& node, const Vocabulary& vocabulary) {
  switch (node.kind) {
    case NodeKind::sequence:
      return "sequence";
    case NodeKind::selector:
      return "selector";
    case NodeKind::condition:
      COPPICE_CHECK(node.index < vocabulary.features.size());
      return fmt::format("{}{}{}", vocabulary.features[node.index].name,
                         node.op == Op::equal ? "=" : "<=", vocabulary.features[node.index].number_text(node.value));
    case NodeKind::action:
      COPPICE_CHECK(node.index < vocabulary.actions.size());
      return vocabulary.actions[node.index];
  }
  COPPICE_CHECK(false);
  return {};
}

}  // namespace coppice
