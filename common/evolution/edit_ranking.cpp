#include "common/evolution/edit_ranking.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "common/check.hpp"
#include "common/evolution/tree_draft.hpp"
#include "common/tree/tree_size.hpp"

namespace coppice {
namespace {

constexpr std::uint8_t kNothing = 0xFF;      // no action is written
constexpr std::size_t kSpareCandidates = 4;  // ranked for each that is asked for: some spell the same tree
constexpr double kNegligible = 1e-7;         // of a gain, beside the largest of any state
constexpr std::size_t kNowhere = SIZE_MAX;

TreeDraft composite_of(NodeKind kind, std::vector<TreeDraft> children) {
  return {Node::composite(kind, 1), std::move(children)};
}

TreeDraft action_leaf(std::uint8_t action) { return {Node::action(ActionId{action})}; }

}  // namespace

struct EditRanking::Candidate {
  enum class EditForm : std::uint8_t {
    action,     // a
    condition,  // c
    branch,     // (sequence c a)
    unless,     // (selector c a)
    choice,     // (selector (sequence c b) a)
    guard,      // (sequence c what-is-there)
    precede,    // (selector (sequence c a) what-is-there)
    remove,
    swap,  // two children of the node
  };

  double gain = 0.0;
  std::ptrdiff_t nodes = 0;  // more than now, before a composite with one child dissolves
  std::size_t order = 0;
  EditForm form = EditForm::action;
  std::size_t node = 0;        // replaced, or the parent of a gap
  std::size_t gap = kNowhere;  // before this child; swap: the first child
  std::size_t other = 0;       // swap: the second child
  Node condition = {};
  std::uint8_t action = 0;
  std::uint8_t second = 0;  // choice: what is done where the condition does not hold

  bool operator<(const Candidate& worse) const {
    return std::tie(worse.gain, nodes, order) < std::tie(gain, worse.nodes, worse.order);
  }
};

// One tree, taken apart. Arrays are [nodes x states that matter], a node's states together.
class EditRanking::Pass {
  using EditForm = Candidate::EditForm;

 public:
  Pass(const EditRanking& ranking, const Tree& tree, std::span<const double> gains, const EditLimits& limits,
       std::size_t count)
      : ranking_(ranking),
        chain_(ranking.chain_),
        tree_(tree),
        gains_(gains),
        limits_(limits),
        stride_(chain_.actions() + 1),
        sums_(stride_ + 1),
        kept_(count * kSpareCandidates),
        conditions_(condition_count(tree.nodes())) {
    choose_states();
    children_.resize(tree.size());
    parent_.assign(tree.size(), kNowhere);
    for (std::size_t i = 0; i < tree.size(); ++i) {
      for (std::size_t c = i + 1; c < i + tree[i].extent; c += tree[c].extent) {
        children_[i].push_back(c);
        parent_[c] = i;
      }
    }
    execute();
    continue_everywhere();
  }

  std::vector<RankedEdit> best(std::size_t count) {
    for (std::size_t node = 0; node < tree_.size(); ++node) {
      rank_node(node);
      if (tree_[node].is_composite()) {
        for (std::size_t gap = 0; gap <= children_[node].size(); ++gap) {
          rank_gap(node, gap);
        }
        rank_swaps(node);
      }
    }
    std::sort(candidates_.begin(), candidates_.end());
    std::vector<RankedEdit> result;
    for (const Candidate& candidate : candidates_) {
      if (result.size() == count) {
        break;
      }
      std::optional<Tree> tree = made(candidate);
      if (tree && fits(*tree) &&
          std::none_of(result.begin(), result.end(), [&](const RankedEdit& better) { return better.tree == *tree; })) {
        result.push_back({candidate.gain, std::move(*tree)});
      }
    }
    return result;
  }

 private:
  // Those whose gains are not negligible beside the largest.
  void choose_states() {
    double largest = 0.0;
    for (const double gain : gains_) {
      largest = std::max(largest, std::abs(gain));
    }
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      const auto row = gains_.subspan(s * stride_, stride_);
      if (std::any_of(row.begin(), row.end(), [&](double gain) { return std::abs(gain) > kNegligible * largest; })) {
        states_.push_back(static_cast<std::uint32_t>(s));
      }
    }
  }

  // What a tick of the node, or of some siblings in turn, gives in one state.
  struct Ticked {
    std::uint8_t succeeds = 0;
    std::uint8_t writes = kNothing;
  };

  std::size_t at(std::size_t node, std::size_t m) const { return node * states_.size() + m; }
  bool is_selector(std::size_t node) const { return tree_[node].kind == NodeKind::selector; }

  bool holds(const Node& condition, std::size_t state) const {
    const std::uint8_t value = chain_.features_of(state)[condition.index];
    return condition.op == Op::equal ? value == condition.value : value <= condition.value;
  }

  // `first`, then what comes after it under a parent of this kind.
  static Ticked then(bool selector, Ticked first, Ticked rest) {
    if ((first.succeeds != 0) == selector) {
      return first;
    }
    return {rest.succeeds, rest.writes != kNothing ? rest.writes : first.writes};
  }

  // Backwards: what each node ticks to. Children come after their parents.
  void execute() {
    const std::size_t size = tree_.size() * states_.size();
    ticked_.resize(size);
    after_.resize(size);
    for (std::size_t i = tree_.size(); i-- > 0;) {
      const Node& node = tree_[i];
      Ticked* const ticked = ticked_.data() + at(i, 0);
      if (node.kind == NodeKind::condition) {
        for (std::size_t m = 0; m < states_.size(); ++m) {
          ticked[m] = {static_cast<std::uint8_t>(holds(node, states_[m])), kNothing};
        }
      } else if (node.kind == NodeKind::action) {
        std::fill_n(ticked, states_.size(), Ticked{1, node.index});
      } else {
        std::fill_n(ticked, states_.size(), Ticked{static_cast<std::uint8_t>(!is_selector(i)), kNothing});
        for (auto child = children_[i].rbegin(); child != children_[i].rend(); ++child) {
          const Ticked* const first = ticked_.data() + at(*child, 0);
          Ticked* const after = after_.data() + at(*child, 0);
          for (std::size_t m = 0; m < states_.size(); ++m) {
            after[m] = ticked[m];
            ticked[m] = then(is_selector(i), first[m], ticked[m]);
          }
        }
      }
    }
    now_.resize(states_.size());
    for (std::size_t m = 0; m < states_.size(); ++m) {
      const std::uint8_t written = ticked_[at(0, m)].writes;
      now_[m] = written != kNothing ? written : static_cast<std::uint8_t>(chain_.actions());
    }
  }

  // Forwards: where a node is reached, with what on the blackboard; and what the tick writes after it.
  void continue_everywhere() {
    const std::size_t size = tree_.size() * states_.size();
    reached_.assign(size, 1);
    board_.assign(size, static_cast<std::uint8_t>(chain_.actions()));
    end_reached_.assign(size, 0);
    end_board_.assign(size, 0);
    succeeded_.assign(size, kNothing);
    failed_.assign(size, kNothing);
    for (std::size_t i = 0; i < tree_.size(); ++i) {
      if (!tree_[i].is_composite()) {
        continue;
      }
      const bool selector = is_selector(i);
      std::uint8_t* const reached = end_reached_.data() + at(i, 0);
      std::uint8_t* const board = end_board_.data() + at(i, 0);
      std::copy_n(reached_.begin() + static_cast<std::ptrdiff_t>(at(i, 0)), states_.size(), reached);
      std::copy_n(board_.begin() + static_cast<std::ptrdiff_t>(at(i, 0)), states_.size(), board);
      for (const std::size_t child : children_[i]) {
        const std::size_t begin = at(child, 0);
        std::copy_n(reached, states_.size(), reached_.begin() + static_cast<std::ptrdiff_t>(begin));
        std::copy_n(board, states_.size(), board_.begin() + static_cast<std::ptrdiff_t>(begin));
        for (std::size_t m = 0; m < states_.size(); ++m) {
          const std::uint8_t later = after(i, after_[begin + m], m);
          succeeded_[begin + m] = selector ? succeeded_[at(i, m)] : later;
          failed_[begin + m] = selector ? later : failed_[at(i, m)];
          const Ticked ticked = ticked_[begin + m];
          reached[m] &= static_cast<std::uint8_t>((ticked.succeeds != 0) != selector);
          board[m] = ticked.writes != kNothing ? ticked.writes : board[m];
        }
      }
    }
  }

  // What is written by the rest of a composite's children, which ticks so, and by all that follows.
  std::uint8_t after(std::size_t parent, Ticked rest, std::size_t m) const {
    const std::uint8_t next = rest.succeeds != 0 ? succeeded_[at(parent, m)] : failed_[at(parent, m)];
    return next != kNothing ? next : rest.writes;
  }

  // What a place makes of a state: the action that the tick selects if the place fails, or succeeds without writing;
  // and whether what it writes is overwritten.
  struct Outcome {
    bool reached = false;
    std::uint8_t on_failure = 0;
    std::uint8_t on_success = 0;
    bool overwritten = false;
  };

  Outcome outcome_of_node(std::size_t node, std::size_t m) const {
    const std::size_t here = at(node, m);
    const auto written = [&](std::uint8_t later) { return later != kNothing ? later : board_[here]; };
    return {reached_[here] != 0, written(failed_[here]), written(succeeded_[here]), succeeded_[here] != kNothing};
  }

  Outcome outcome_of_gap(std::size_t parent, std::size_t gap, std::size_t m) const {
    const bool at_end = gap == children_[parent].size();
    const std::size_t here = at_end ? kNowhere : at(children_[parent][gap], m);
    const bool reached = (at_end ? end_reached_[at(parent, m)] : reached_[here]) != 0;
    const std::uint8_t board = at_end ? end_board_[at(parent, m)] : board_[here];
    const std::uint8_t success = succeeded_[at(parent, m)];
    const std::uint8_t failure = failed_[at(parent, m)];
    if (is_selector(parent)) {
      return {reached, now_[m], success != kNothing ? success : board, success != kNothing};
    }
    const Ticked rest = at_end ? Ticked{1, kNothing} : then(false, ticked_[here], after_[here]);
    return {reached, failure != kNothing ? failure : board, now_[m], after(parent, rest, m) != kNothing};
  }

  // Sums of what each outcome gains over what is done now, over the states in which the place is reached, in all and
  // for each value of each feature. [sums]: failure, success, then each action written. False: it is reached nowhere.
  template <typename OutcomeOf>
  bool add_up(const OutcomeOf& outcome_of) {
    switch (sums_) {  // a number known to the compiler becomes vector instructions
      case 4:
        return add_up_sums<4>(outcome_of);
      case 5:
        return add_up_sums<5>(outcome_of);
      case 6:
        return add_up_sums<6>(outcome_of);
      case 7:
        return add_up_sums<7>(outcome_of);
      case 8:
        return add_up_sums<8>(outcome_of);
      default:
        return add_up_sums<0>(outcome_of);
    }
  }

  // kSums: sums_, or 0 for any.
  template <std::size_t kSums, typename OutcomeOf>
  bool add_up_sums(const OutcomeOf& outcome_of) {
    const std::size_t sums = kSums > 0 ? kSums : sums_;
    total_.assign(sums, 0.0);
    by_value_.assign(std::size_t{ranking_.first_slot_.back()} * sums, 0.0);
    row_.resize(sums);
    bool any = false;
    const std::size_t features = ranking_.first_slot_.size() - 1;
    double* const row = row_.data();
    for (std::size_t m = 0; m < states_.size(); ++m) {
      const Outcome outcome = outcome_of(m);
      if (!outcome.reached) {
        continue;
      }
      any = true;
      const double* gain = gains_.data() + states_[m] * stride_;
      const double so_far = gain[now_[m]];
      row[0] = gain[outcome.on_failure] - so_far;
      row[1] = gain[outcome.on_success] - so_far;
      for (std::size_t a = 2; a < sums; ++a) {
        row[a] = outcome.overwritten ? row[1] : gain[a - 2] - so_far;
      }
      add<kSums>(row, total_.data());
      const std::uint32_t* slots = ranking_.slot_.data() + states_[m] * features;
      for (std::size_t f = 0; f < features; ++f) {
        add<kSums>(row, by_value_.data() + std::size_t{slots[f]} * sums);
      }
    }
    return any;
  }

  template <std::size_t kSums>
  void add(const double* row, double* to) const {
    const std::size_t sums = kSums > 0 ? kSums : sums_;
    for (std::size_t k = 0; k < sums; ++k) {
      to[k] += row[k];
    }
  }

  // Calls use(condition, sums where it holds) for every condition of the vocabulary.
  template <typename Use>
  void for_conditions(const Use& use) {
    const Vocabulary& vocabulary = chain_.vocabulary();
    for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
      const Feature& feature = vocabulary.features[f];
      up_to_.assign(sums_, 0.0);
      for (std::size_t v = 0; v < feature.values.size(); ++v) {
        const double* sums = by_value_.data() + (ranking_.first_slot_[f] + v) * sums_;
        if (feature.admits_equal) {
          use(Node::condition(f, Op::equal, feature.values[v]), sums);
        }
        if (feature.admits_less_equal) {
          for (std::size_t k = 0; k < sums_; ++k) {
            up_to_[k] += sums[k];
          }
          if (v + 1 < feature.values.size()) {  // the last one always holds
            use(Node::condition(f, Op::less_equal, feature.values[v]), up_to_.data());
          }
        }
      }
    }
  }

  // Takes it in if it is within the limits and among the best so far.
  void offer(Candidate candidate, std::ptrdiff_t conditions) {
    if (static_cast<std::ptrdiff_t>(tree_.size()) + candidate.nodes > static_cast<std::ptrdiff_t>(limits_.max_nodes) ||
        static_cast<std::ptrdiff_t>(conditions_) + conditions > static_cast<std::ptrdiff_t>(limits_.max_conditions)) {
      return;
    }
    candidate.order = order_++;
    if (candidates_.size() == kept_) {
      if (!(candidate < candidates_.front())) {
        return;
      }
      std::pop_heap(candidates_.begin(), candidates_.end());
      candidates_.pop_back();
    }
    candidates_.push_back(candidate);
    std::push_heap(candidates_.begin(), candidates_.end());
  }

  // The action, other than `but`, that gains most where a condition holds, or where it does not; kNowhere: there is
  // none.
  std::size_t best_where(const double* where, std::size_t but) const {
    return best_action(but, [&](std::size_t a) { return where[2 + a]; });
  }
  std::size_t best_elsewhere(const double* where, std::size_t but) const {
    return best_action(but, [&](std::size_t a) { return total_[2 + a] - where[2 + a]; });
  }
  template <typename GainOf>
  std::size_t best_action(std::size_t but, const GainOf& gain_of) const {
    std::size_t best = kNowhere;
    for (std::size_t a = 0; a + 1 < stride_; ++a) {
      if (a != but && (best == kNowhere || gain_of(a) > gain_of(best))) {
        best = a;
      }
    }
    return best;
  }

  void rank_node(std::size_t node) {
    if (!add_up([&](std::size_t m) { return outcome_of_node(node, m); })) {
      return;
    }
    const Node& old = tree_[node];
    const double base = base_gain();
    const auto removed = static_cast<std::ptrdiff_t>(old.extent);
    const auto tests = static_cast<std::ptrdiff_t>(condition_count(tree_.subtree(node)));
    const bool in_selector = parent_[node] != kNowhere && is_selector(parent_[node]);
    const bool in_sequence = parent_[node] != kNowhere && !is_selector(parent_[node]);
    const auto replace = [&](EditForm form, double gain, std::ptrdiff_t nodes, std::ptrdiff_t conditions) {
      Candidate candidate;
      candidate.gain = base + gain;
      candidate.nodes = nodes - removed;
      candidate.form = form;
      candidate.node = node;
      return std::pair{candidate, conditions - tests};
    };
    const bool is_condition = old.kind == NodeKind::condition;
    if (parent_[node] != kNowhere && children_[parent_[node]].size() > 1) {
      const auto [candidate, conditions] = replace(EditForm::remove, in_selector ? total_[0] : total_[1], 0, 0);
      if (!(limits_.guarded && in_sequence && !is_condition)) {
        offer(candidate, conditions);
      }
    }
    const bool action_fits = !(limits_.guarded && is_condition);
    for (std::size_t a = 0; a + 1 < stride_ && action_fits; ++a) {
      if (!(old.kind == NodeKind::action && old.index == a)) {
        auto [candidate, conditions] = replace(EditForm::action, total_[2 + a], 1, 0);
        candidate.action = static_cast<std::uint8_t>(a);
        offer(candidate, conditions);
      }
    }
    for_conditions([&](const Node& condition, const double* where) {
      const auto put = [&](EditForm form, double gain, std::ptrdiff_t nodes, std::ptrdiff_t more, std::size_t action,
                           std::size_t second) {
        auto [candidate, conditions] = replace(form, gain, nodes, more);
        candidate.condition = condition;
        candidate.action = static_cast<std::uint8_t>(action);
        candidate.second = static_cast<std::uint8_t>(second);
        offer(candidate, conditions);
      };
      const double fails = total_[0] - where[0];
      if ((!limits_.guarded || is_condition) && !(is_condition && old == condition)) {
        put(EditForm::condition, where[1] + fails, 1, 1, 0, 0);
      }
      if (limits_.guarded && is_condition) {
        return;
      }
      if (!in_sequence && removed > 1) {
        for (std::size_t a = 0; a + 1 < stride_; ++a) {
          put(EditForm::branch, where[2 + a] + fails, 3, 1, a, 0);
        }
      }
      if (!limits_.guarded && !in_selector) {
        const std::size_t a = best_elsewhere(where, kNowhere);
        put(EditForm::unless, where[1] + total_[2 + a] - where[2 + a], 3, 1, a, 0);
      }
      if (!in_selector) {
        const std::size_t first = best_where(where, kNowhere);
        const std::size_t second = best_elsewhere(where, first);
        const auto choose = [&](std::size_t x, std::size_t y) {
          if (x != kNowhere && y != kNowhere && x != y) {
            put(EditForm::choice, where[2 + x] + total_[2 + y] - where[2 + y], 5, 1, x, y);
          }
        };
        choose(first, second);
        choose(best_where(where, second), second);
        if (old.kind == NodeKind::action) {
          choose(old.index, best_elsewhere(where, old.index));
          choose(best_where(where, old.index), old.index);
        }
      }
      if (!in_sequence && old.kind != NodeKind::sequence) {
        put(EditForm::guard, fails, removed + 2, 1 + tests, 0, 0);
      }
      if (!in_selector && old.kind != NodeKind::selector) {
        for (std::size_t a = 0; a + 1 < stride_; ++a) {
          put(EditForm::precede, where[2 + a], removed + 4, 1 + tests, a, 0);
        }
      }
    });
  }

  void rank_gap(std::size_t parent, std::size_t gap) {
    const std::vector<std::size_t>& children = children_[parent];
    const bool selector = is_selector(parent);
    // Behind what always succeeds nothing is reached; add_up() finds that out. In a guarded sequence: before the
    // action.
    const bool for_condition =
        !limits_.guarded || (!selector && gap < children.size() &&
                             std::all_of(children.begin(), children.begin() + static_cast<std::ptrdiff_t>(gap),
                                         [&](std::size_t c) { return tree_[c].kind == NodeKind::condition; }));
    const bool for_branch = !limits_.guarded || selector;
    if ((!for_condition && !for_branch) || !add_up([&](std::size_t m) { return outcome_of_gap(parent, gap, m); })) {
      return;
    }
    const double base = base_gain();
    const auto put = [&](EditForm form, double gain, std::ptrdiff_t nodes, std::ptrdiff_t more, const Node& condition,
                         std::size_t action) {
      Candidate candidate;
      candidate.gain = base + gain;
      candidate.nodes = nodes;
      candidate.form = form;
      candidate.node = parent;
      candidate.gap = gap;
      candidate.condition = condition;
      candidate.action = static_cast<std::uint8_t>(action);
      offer(candidate, more);
    };
    for (std::size_t a = 0; a + 1 < stride_ && for_branch; ++a) {
      put(EditForm::action, total_[2 + a], 1, 0, Node{}, a);
    }
    for_conditions([&](const Node& condition, const double* where) {
      const double fails = total_[0] - where[0];
      if (for_condition) {
        put(EditForm::condition, where[1] + fails, 1, 1, condition, 0);
      }
      if (!for_branch) {
        return;
      }
      for (std::size_t a = 0; a + 1 < stride_; ++a) {
        if (selector) {
          put(EditForm::branch, where[2 + a] + fails, 3, 1, condition, a);
        } else {
          put(EditForm::unless, where[1] + total_[2 + a] - where[2 + a], 3, 1, condition, a);
        }
      }
    });
  }

  void rank_swaps(std::size_t parent) {
    const std::vector<std::size_t>& children = children_[parent];
    if (limits_.guarded && !is_selector(parent)) {
      return;
    }
    for (std::size_t a = 0; a < children.size(); ++a) {
      for (std::size_t b = a + 1; b < children.size(); ++b) {
        if (tree_[children[a]].kind == NodeKind::condition && tree_[children[b]].kind == NodeKind::condition) {
          continue;
        }
        Candidate candidate;
        candidate.form = EditForm::swap;
        candidate.node = parent;
        candidate.gap = a;
        candidate.other = b;
        candidate.gain = gain_swapped(parent, a, b);
        offer(candidate, 0);
      }
    }
  }

  // What is selected when two children have changed places, from what each of them ticks to.
  double gain_swapped(std::size_t parent, std::size_t a, std::size_t b) const {
    const std::vector<std::size_t>& children = children_[parent];
    double gain = 0.0;
    for (std::size_t m = 0; m < states_.size(); ++m) {
      const double* gains = gains_.data() + states_[m] * stride_;
      const std::size_t here = at(children[a], m);
      if (reached_[here] == 0) {
        gain += gains[now_[m]];
        continue;
      }
      Ticked rest = after_[at(children[b], m)];
      rest = then(is_selector(parent), ticked_[here], rest);
      for (std::size_t k = b; k-- > a + 1;) {
        rest = then(is_selector(parent), ticked_[at(children[k], m)], rest);
      }
      rest = then(is_selector(parent), ticked_[at(children[b], m)], rest);
      const std::uint8_t later = after(parent, rest, m);
      gain += gains[later != kNothing ? later : board_[here]];
    }
    return gain;
  }

  // What the tree itself gains.
  double base_gain() {
    if (!base_) {
      base_ = 0.0;
      for (std::size_t m = 0; m < states_.size(); ++m) {
        *base_ += gains_[states_[m] * stride_ + now_[m]];
      }
    }
    return *base_;
  }

  std::optional<Tree> made(const Candidate& candidate) const {
    TreeDraft root = TreeDraft::of(tree_.nodes());
    const TreeDraft::Place place = root.places()[candidate.node];
    TreeDraft& draft = *place.draft;
    const TreeDraft condition{candidate.condition};
    TreeDraft put = action_leaf(candidate.action);
    switch (candidate.form) {
      case EditForm::action:
        break;
      case EditForm::condition:
        put = condition;
        break;
      case EditForm::branch:
        put = composite_of(NodeKind::sequence, {condition, put});
        break;
      case EditForm::unless:
        put = composite_of(NodeKind::selector, {condition, put});
        break;
      case EditForm::choice:
        put = composite_of(NodeKind::selector,
                           {composite_of(NodeKind::sequence, {condition, put}), action_leaf(candidate.second)});
        break;
      case EditForm::guard:
        put = composite_of(NodeKind::sequence, {condition, draft});
        break;
      case EditForm::precede:
        put = composite_of(NodeKind::selector, {composite_of(NodeKind::sequence, {condition, put}), draft});
        break;
      case EditForm::remove:
      case EditForm::swap:
        break;
    }
    if (candidate.form == EditForm::remove) {
      place.parent->remove(place.index());
    } else if (candidate.form == EditForm::swap) {
      std::swap(draft.children[candidate.gap], draft.children[candidate.other]);
    } else if (candidate.gap != kNowhere) {
      draft.insert(candidate.gap, std::move(put));
    } else {
      draft = std::move(put);
    }
    root.tidy();
    return root.finished();
  }

  bool fits(const Tree& tree) const {
    return tree.size() <= limits_.max_nodes && condition_count(tree.nodes()) <= limits_.max_conditions && tree != tree_;
  }

  const EditRanking& ranking_;
  const Chain& chain_;
  const Tree& tree_;
  std::span<const double> gains_;
  EditLimits limits_;
  std::size_t stride_;
  std::size_t sums_;  // failure, success, and each action
  std::size_t kept_;
  std::size_t conditions_;
  std::vector<std::uint32_t> states_;
  std::vector<std::vector<std::size_t>> children_;
  std::vector<std::size_t> parent_;
  std::vector<Ticked> ticked_;
  std::vector<Ticked> after_;      // of the siblings behind
  std::vector<std::uint8_t> now_;  // [states that matter], what the tree does
  std::vector<std::uint8_t> reached_;
  std::vector<std::uint8_t> board_;
  std::vector<std::uint8_t> end_reached_;  // behind the last child
  std::vector<std::uint8_t> end_board_;
  std::vector<std::uint8_t> succeeded_;  // what is written later if the node succeeds
  std::vector<std::uint8_t> failed_;
  std::vector<double> total_;
  std::vector<double> by_value_;  // [values of all features x sums]
  std::vector<double> up_to_;
  std::vector<double> row_;
  std::optional<double> base_;
  std::size_t order_ = 0;
  std::vector<Candidate> candidates_;  // a heap, the worst first
};

EditRanking::EditRanking(const Chain& chain) : chain_(chain) {
  const Vocabulary& vocabulary = chain.vocabulary();
  first_slot_.assign(1, 0);
  for (const Feature& feature : vocabulary.features) {
    first_slot_.push_back(first_slot_.back() + static_cast<std::uint32_t>(feature.values.size()));
  }
  slot_.reserve(chain.states() * vocabulary.features.size());
  for (std::size_t s = 0; s < chain.states(); ++s) {
    for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
      const std::vector<std::uint8_t>& values = vocabulary.features[f].values;
      const auto found = std::lower_bound(values.begin(), values.end(), chain.features_of(s)[f]);
      slot_.push_back(first_slot_[f] + static_cast<std::uint32_t>(found - values.begin()));
    }
  }
}

std::vector<RankedEdit> EditRanking::best(const Tree& tree, std::span<const double> gains, const EditLimits& limits,
                                          std::size_t count) {
  COPPICE_CHECK(gains.size() == chain_.states() * (chain_.actions() + 1) && count >= 1);
  return Pass(*this, tree, gains, limits, count).best(count);
}

double EditRanking::gain_of(std::span<const std::uint8_t> actions, std::span<const double> gains) const {
  COPPICE_CHECK(actions.size() == chain_.states());
  double sum = 0.0;
  for (std::size_t s = 0; s < actions.size(); ++s) {
    sum += gains[s * (chain_.actions() + 1) + actions[s]];
  }
  return sum;
}

}  // namespace coppice
