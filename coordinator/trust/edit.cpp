#include "coordinator/trust/edit.hpp"

#include <charconv>
#include <fmt/format.h>

#include "common/tree/text.hpp"

namespace coppice {
namespace {

constexpr std::string_view kBlank = " \t";

// Takes a whole number off the front of `text`.
Result<std::size_t> take_number(std::string_view& text, std::string_view what) {
  const std::size_t begin = text.find_first_not_of(kBlank);
  const std::string_view rest = begin == std::string_view::npos ? std::string_view() : text.substr(begin);
  const std::string_view word = rest.substr(0, rest.find_first_of(kBlank));
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (word.empty() || error != std::errc{} || end != word.data() + word.size()) {
    return bad_input(fmt::format("found '{}', expected {}", word, what));
  }
  text = rest.substr(word.size());
  return number;
}

constexpr std::string_view kNodeNumber = "the number of a node";
constexpr std::string_view kPosition = "the position of the new child, from 0";

class Editing {
 public:
  Editing(const Tree& tree, const std::vector<TreeEdit>& edits) : tree_(tree), edits_(edits), change_of_(tree.size()) {}

  Result<Tree> run() {
    for (const TreeEdit& edit : edits_) {
      if (const Result<void> checked = enter(edit); !checked) {
        return tl::unexpected(checked.error());
      }
    }
    if (const Result<void> checked = check_overlaps(); !checked) {
      return tl::unexpected(checked.error());
    }
    if (const Result<std::size_t> copied = copy(0); !copied) {
      return tl::unexpected(copied.error());
    }
    Result<Tree> result = Tree::from_nodes(std::move(nodes_));
    return result ? std::move(result) : in_context("the tree after the changes", std::move(result).error());
  }

 private:
  Result<void> enter(const TreeEdit& edit) {
    if (edit.node >= tree_.size()) {
      return bad_input(fmt::format("there is no node {}: expected 0 to {}", edit.node, tree_.size() - 1));
    }
    if (edit.kind == TreeEdit::Kind::insert) {
      const std::size_t children = child_count(tree_.subtree(edit.node));
      if (tree_[edit.node].is_leaf()) {
        return bad_input(fmt::format("node {} is a leaf: expected a sequence or a selector to insert into", edit.node));
      }
      if (edit.position > children) {
        return bad_input(fmt::format("node {} has {} children: expected a position of 0 to {}, found {}", edit.node,
                                     children, children, edit.position));
      }
      return {};
    }
    if (edit.kind == TreeEdit::Kind::remove && edit.node == 0) {
      return bad_input("node 0 is the whole tree: expected another to delete, or 0 to replace");
    }
    if (change_of_[edit.node] != nullptr) {
      return bad_input(fmt::format("node {} is replaced or deleted twice", edit.node));
    }
    change_of_[edit.node] = &edit;
    return {};
  }

  Result<void> check_overlaps() const {
    for (const TreeEdit& edit : edits_) {
      // Its own node counts for an insertion: what goes takes no child.
      for (std::size_t node = 0; node <= edit.node; ++node) {
        const bool around = node + tree_[node].extent > edit.node && change_of_[node] != nullptr &&
                            (node != edit.node || edit.kind == TreeEdit::Kind::insert);
        if (around) {
          return bad_input(fmt::format("the change at node {} lies within node {}, which goes", edit.node, node));
        }
      }
    }
    return {};
  }

  void append(const Tree& subtree) { nodes_.insert(nodes_.end(), subtree.nodes().begin(), subtree.nodes().end()); }

  // Appends what becomes of the subtree at `node`; returns how many nodes that is. As deep as the tree.
  Result<std::size_t> copy(std::size_t node) {
    const std::size_t begin = nodes_.size();
    if (const TreeEdit* change = change_of_[node]; change != nullptr) {
      if (change->subtree) {
        append(*change->subtree);
      }
      return nodes_.size() - begin;
    }
    nodes_.push_back(tree_[node]);
    if (tree_[node].is_leaf()) {
      return std::size_t{1};
    }
    std::size_t position = 0;
    for (std::size_t child = node + 1; child < node + tree_[node].extent; child += tree_[child].extent, ++position) {
      insert_at(node, position);
      if (const Result<std::size_t> copied = copy(child); !copied) {
        return copied;
      }
    }
    insert_at(node, position);
    const std::size_t extent = nodes_.size() - begin;
    if (extent == 1) {
      return bad_input(fmt::format("node {} would be left without children: expected to delete it instead", node));
    }
    if (extent > kMaxTreeNodes) {
      return bad_input(fmt::format("the tree would have more than {} nodes", kMaxTreeNodes));
    }
    nodes_[begin].extent = static_cast<std::uint16_t>(extent);
    return extent;
  }

  void insert_at(std::size_t node, std::size_t position) {
    for (const TreeEdit& edit : edits_) {
      if (edit.kind == TreeEdit::Kind::insert && edit.node == node && edit.position == position) {
        append(*edit.subtree);
      }
    }
  }

  const Tree& tree_;
  const std::vector<TreeEdit>& edits_;
  std::vector<const TreeEdit*> change_of_;  // [nodes] what replaces or deletes it
  std::vector<Node> nodes_;
};

}  // namespace

Result<TreeEdit> parse_edit(TreeEdit::Kind kind, std::string_view text, const Vocabulary& vocabulary) {
  TreeEdit edit{.kind = kind};
  const Result<std::size_t> node = take_number(text, kNodeNumber);
  if (!node) {
    return tl::unexpected(node.error());
  }
  edit.node = *node;
  if (kind == TreeEdit::Kind::insert) {
    const Result<std::size_t> position = take_number(text, kPosition);
    if (!position) {
      return tl::unexpected(position.error());
    }
    edit.position = *position;
  }
  if (kind == TreeEdit::Kind::remove) {
    if (text.find_first_not_of(kBlank) != std::string_view::npos) {
      return bad_input(fmt::format("found '{}' behind the number of the node, expected nothing", text));
    }
    return edit;
  }
  Result<Tree> subtree = parse_tree(text, vocabulary);
  if (!subtree) {
    return in_context("the subtree", std::move(subtree).error());
  }
  edit.subtree = std::move(*subtree);
  return edit;
}

Result<Tree> apply_edits(const Tree& tree, const std::vector<TreeEdit>& edits) { return Editing(tree, edits).run(); }

}  // namespace coppice
