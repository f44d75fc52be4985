#include "common/chain/exact_classes.hpp"

#include <algorithm>

namespace coppice {
namespace {

constexpr std::uint32_t kUnseen = 0xFFFFFFFF;

// Nodes are the states and, last, the hub: a state with a uniform share leads to the hub, and the hub to every state.
class Tarjan {
 public:
  explicit Tarjan(const ReachedRows& rows) : rows_(rows), hub_(static_cast<std::uint32_t>(rows.size())) {
    order_.assign(rows.size() + 1, kUnseen);
    low_.assign(rows.size() + 1, 0);
    component_.assign(rows.size() + 1, kUnseen);
  }

  void run() {
    for (std::uint32_t node = 0; node < hub_; ++node) {  // episodes may start in several
      if (order_[node] == kUnseen) {
        visit(node);
        run_from_path();
      }
    }
  }

  std::vector<std::uint32_t> closed() const {
    std::vector<bool> leaves(components_, false);
    std::vector<std::uint32_t> lowest(components_, kTransient);
    for (std::uint32_t node = 0; node <= hub_; ++node) {
      if (order_[node] == kUnseen) {
        continue;  // the hub of a chain without uniform shares
      }
      const std::uint32_t component = component_[node];
      lowest[component] = std::min(lowest[component], node);
      for (std::size_t i = 0; i < degree(node); ++i) {
        leaves[component] = leaves[component] || component_[successor(node, i)] != component;
      }
    }
    std::vector<std::uint32_t> result(rows_.size());
    for (std::uint32_t node = 0; node < hub_; ++node) {
      result[node] = leaves[component_[node]] ? kTransient : lowest[component_[node]];
    }
    return result;
  }

 private:
  struct Visit {
    std::uint32_t node = 0;
    std::size_t next = 0;  // the next successor to look at
  };

  std::size_t degree(std::uint32_t node) const {
    return node == hub_ ? rows_.size() : rows_.row(node).size() + (rows_.uniform(node) > 0.0 ? 1 : 0);
  }
  std::uint32_t successor(std::uint32_t node, std::size_t i) const {
    if (node == hub_) {
      return static_cast<std::uint32_t>(i);
    }
    return i < rows_.row(node).size() ? rows_.row(node)[i].to : hub_;
  }

  void run_from_path() {
    while (!path_.empty()) {
      Visit& top = path_.back();
      if (top.next == degree(top.node)) {
        leave();
        continue;
      }
      const std::uint32_t to = successor(top.node, top.next++);
      if (order_[to] == kUnseen) {
        visit(to);
      } else if (component_[to] == kUnseen) {
        low_[top.node] = std::min(low_[top.node], order_[to]);
      }
    }
  }

  void visit(std::uint32_t node) {
    order_[node] = low_[node] = seen_++;
    open_.push_back(node);
    path_.push_back({node, 0});
  }

  void leave() {
    const std::uint32_t node = path_.back().node;
    path_.pop_back();
    if (!path_.empty()) {
      low_[path_.back().node] = std::min(low_[path_.back().node], low_[node]);
    }
    if (low_[node] != order_[node]) {
      return;
    }
    std::uint32_t member = kUnseen;
    do {
      member = open_.back();
      open_.pop_back();
      component_[member] = components_;
    } while (member != node);
    ++components_;
  }

  const ReachedRows& rows_;
  std::uint32_t hub_;
  std::uint32_t seen_ = 0;
  std::uint32_t components_ = 0;
  std::vector<std::uint32_t> order_;      // [nodes], of the first visit
  std::vector<std::uint32_t> low_;        // [nodes], the earliest node known to be in the same component
  std::vector<std::uint32_t> component_;  // [nodes]
  std::vector<std::uint32_t> open_;       // nodes without a component yet
  std::vector<Visit> path_;
};

}  // namespace

std::vector<std::uint32_t> closed_classes(const ReachedRows& rows) {
  Tarjan tarjan(rows);
  tarjan.run();
  return tarjan.closed();
}

}  // namespace coppice
