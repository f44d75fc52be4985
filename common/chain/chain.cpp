#include "common/chain/chain.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include "common/check.hpp"

namespace coppice {
namespace {

// Of all states together: so that a sum of them is an integer score.
constexpr std::uint64_t kMaxVisits = std::uint64_t{1} << 62U;

Result<void> check_sizes(const ChainParts& parts) {
  const std::size_t states = parts.policy.size();
  const std::size_t rows = states * parts.vocabulary.actions.size();
  if (states == 0 || states > kMaxStates) {
    return bad_input(fmt::format("chain has {} states: expected 1 to {}", states, kMaxStates));
  }
  if (parts.successor.size() > kMaxTransitions) {
    return bad_input(
        fmt::format("chain has {} transitions: expected at most {}", parts.successor.size(), kMaxTransitions));
  }
  const auto expect = [](const char* what, std::size_t found, std::size_t expected) -> Result<void> {
    if (found != expected) {
      return bad_input(fmt::format("chain's {} has {} entries: expected {}", what, found, expected));
    }
    return {};
  };
  struct Size {
    const char* what;
    std::size_t found;
    std::size_t expected;
  };
  for (const Size& size :
       {Size{"features", parts.features.size(), states * parts.vocabulary.features.size()},
        Size{"row_begin", parts.row_begin.size(), rows + 1}, Size{"count", parts.count.size(), parts.successor.size()},
        Size{"reward_sum", parts.reward_sum.size(), rows}, Size{"q", parts.q.size(), rows},
        Size{"visits", parts.visits.size(), states}}) {
    if (auto ok = expect(size.what, size.found, size.expected); !ok) {
      return ok;
    }
  }
  if (parts.initial_state >= states) {
    return bad_input(fmt::format("chain's initial state is {}: expected below {}", parts.initial_state, states));
  }
  for (const Size& size :
       {Size{"forbidden", parts.forbidden.size(), rows}, Size{"collisions", parts.collisions.size(), rows}}) {
    if (size.found != 0) {
      if (auto ok = expect(size.what, size.found, size.expected); !ok) {
        return ok;
      }
    }
  }
  return {};
}

Result<void> check_episodes(const ChainParts& parts) {
  const std::size_t states = parts.policy.size();
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < parts.starts.size(); ++i) {
    const StartShare& start = parts.starts[i];
    if (start.state >= states || start.count == 0) {
      return bad_input(
          fmt::format("start {} is state {} with count {}: expected a state below {} and a count of 1 or "
                      "more",
                      i, start.state, start.count, states));
    }
    if (i > 0 && start.state <= parts.starts[i - 1].state) {
      return bad_input(fmt::format("starts are not ascending at {}", i));
    }
    total += start.count;
  }
  if (total >> 32U != 0) {
    return bad_input(fmt::format("starts have counts of {} in all: expected below 2^32", total));
  }
  if (!parts.starts.empty() && (parts.starts.size() == 1 || parts.starts.front().state != parts.initial_state)) {
    return bad_input(
        fmt::format("{} starts, the first state {}: expected none or several, beginning with the initial "
                    "state {}",
                    parts.starts.size(), parts.starts.front().state, parts.initial_state));
  }
  for (std::size_t i = 0; i < parts.terminals.size(); ++i) {
    if (parts.terminals[i] >= states || (i > 0 && parts.terminals[i] <= parts.terminals[i - 1])) {
      return bad_input(
          fmt::format("terminal {} is state {}: expected ascending states below {}", i, parts.terminals[i], states));
    }
  }
  const std::size_t actions = parts.vocabulary.actions.size();
  const bool named = parts.no_action.kind == NoAction::Kind::named;
  if (parts.no_action.kind > NoAction::Kind::named ||
      index_of(parts.no_action.action) >= (named ? actions : std::size_t{1})) {
    return bad_input(
        fmt::format("no action is kind {}, action {}: expected kind 0 to 2, and an action below {} with "
                    "kind 2 only",
                    static_cast<unsigned>(parts.no_action.kind), index_of(parts.no_action.action), actions));
  }
  return {};
}

Result<void> check_states(const ChainParts& parts) {
  const std::size_t states = parts.policy.size();
  const std::size_t width = parts.vocabulary.features.size();
  for (std::size_t state = 0; state < states; ++state) {
    if (index_of(parts.policy[state]) >= parts.vocabulary.actions.size()) {
      return bad_input(fmt::format("state {} has policy action {}: expected below {}", state,
                                   index_of(parts.policy[state]), parts.vocabulary.actions.size()));
    }
    for (std::size_t f = 0; f < width; ++f) {
      const Feature& feature = parts.vocabulary.features[f];
      const std::uint8_t value = parts.features[state * width + f];
      if (!std::binary_search(feature.values.begin(), feature.values.end(), value)) {
        return bad_input(fmt::format("state {} reads {} on feature '{}': expected one of {}", state, value,
                                     feature.name, fmt::join(feature.values, ", ")));
      }
    }
  }
  std::uint64_t visited = 0;
  for (const std::uint64_t visits : parts.visits) {
    visited += std::min(visits, kMaxVisits);
    if (visited >= kMaxVisits) {
      return bad_input(
          fmt::format("states were visited {} times or more in all: expected below {}", visited, kMaxVisits));
    }
  }
  if (parts.look_alikes) {
    return {};
  }
  std::vector<std::uint32_t> order(states);
  std::iota(order.begin(), order.end(), 0U);
  const auto features_of = [&](std::uint32_t state) {
    return std::span<const std::uint8_t>(parts.features).subspan(state * width, width);
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const auto left = features_of(a);
    const auto right = features_of(b);
    return std::lexicographical_compare(left.begin(), left.end(), right.begin(), right.end());
  });
  for (std::size_t i = 1; i < states; ++i) {
    const auto left = features_of(order[i - 1]);
    const auto right = features_of(order[i]);
    if (std::equal(left.begin(), left.end(), right.begin())) {
      return bad_input(fmt::format("states {} and {} have the same features", order[i - 1], order[i]));
    }
  }
  return {};
}

Result<std::uint64_t> check_row(const ChainParts& parts, std::size_t row) {
  const std::uint64_t begin = parts.row_begin[row];
  const std::uint64_t end = parts.row_begin[row + 1];
  if (begin > end || end > parts.successor.size()) {
    return bad_input(fmt::format("row {} spans transitions {} to {} of {}", row, begin, end, parts.successor.size()));
  }
  std::uint64_t total = 0;
  for (std::uint64_t i = begin; i < end; ++i) {
    if (parts.successor[i] >= parts.policy.size()) {
      return bad_input(
          fmt::format("row {} leads to state {}: expected below {}", row, parts.successor[i], parts.policy.size()));
    }
    if (i > begin && parts.successor[i] <= parts.successor[i - 1]) {
      return bad_input(fmt::format("row {}: successors are not ascending at transition {}", row, i));
    }
    if (parts.count[i] == 0) {
      return bad_input(fmt::format("row {}: transition {} has count 0: expected 1 or more", row, i));
    }
    total += parts.count[i];
  }
  if (total >> 32U != 0) {
    return bad_input(fmt::format("row {} was tried {} times: expected below 2^32", row, total));
  }
  if (!std::isfinite(parts.reward_sum[row]) || !std::isfinite(parts.q[row])) {
    return bad_input(fmt::format("row {}: reward or Q-value is not finite", row));
  }
  if (!parts.forbidden.empty() && parts.forbidden[row] > 1) {
    return bad_input(fmt::format("row {}: forbidden is {}: expected 0 or 1", row, parts.forbidden[row]));
  }
  if (!parts.forbidden.empty() && parts.forbidden[row] != 0 && (total != 0 || parts.reward_sum[row] != 0.0)) {
    return bad_input(fmt::format("row {} is forbidden and was tried {} times, with reward {}: expected neither", row,
                                 total, parts.reward_sum[row]));
  }
  if (!parts.collisions.empty() && parts.collisions[row] > total) {
    return bad_input(
        fmt::format("row {} has {} collisions in {} tries: expected no more", row, parts.collisions[row], total));
  }
  return total;
}

// The policy takes what the state has; a state that ends episodes is the same whatever is chosen.
Result<void> check_choices(const Chain& chain) {
  const ChainParts& parts = chain.parts();
  const std::size_t actions = chain.actions();
  for (std::size_t state = 0; state < chain.states() && !parts.forbidden.empty(); ++state) {
    const auto begin = parts.forbidden.begin() + static_cast<std::ptrdiff_t>(state * actions);
    if (chain.is_forbidden(state, index_of(chain.policy(state))) &&
        std::find(begin, begin + static_cast<std::ptrdiff_t>(actions), 0) !=
            begin + static_cast<std::ptrdiff_t>(actions)) {
      return bad_input(fmt::format("state {}: the policy takes action {}, which is forbidden there", state,
                                   index_of(chain.policy(state))));
    }
  }
  for (const std::uint32_t state : parts.terminals) {
    const std::size_t first = std::size_t{state} * actions;
    for (std::size_t row = first; row < first + actions; ++row) {
      const auto same = [row, first](const auto& of_row) {
        const auto left = of_row(row);
        const auto right = of_row(first);
        return std::equal(left.begin(), left.end(), right.begin(), right.end());
      };
      if (chain.tries(row) == 0 || parts.reward_sum[row] != 0.0 ||
          !same([&](std::size_t of) { return chain.successors(of); }) ||
          !same([&](std::size_t of) { return chain.counts(of); })) {
        return bad_input(
            fmt::format("state {} ends episodes, and row {} is not like the others of the state: expected "
                        "the same successors with the same counts, without reward",
                        state, row));
      }
    }
  }
  return {};
}

}  // namespace

Result<Chain> Chain::make(ChainParts parts) {
  if (auto ok = check_vocabulary(parts.vocabulary); !ok) {
    return in_context("chain", ok.error());
  }
  if (auto ok = check_sizes(parts); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = check_episodes(parts); !ok) {
    return in_context("chain", ok.error());
  }
  if (auto ok = check_states(parts); !ok) {
    return in_context("chain", ok.error());
  }
  if (parts.row_begin.front() != 0 || parts.row_begin.back() != parts.successor.size()) {
    return bad_input(fmt::format("chain's rows cover transitions {} to {}: expected 0 to {}", parts.row_begin.front(),
                                 parts.row_begin.back(), parts.successor.size()));
  }
  Chain chain(std::move(parts));
  const std::size_t rows = chain.states() * chain.actions();
  chain.tries_.resize(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    auto total = check_row(chain.parts_, row);
    if (!total) {
      return in_context("chain", total.error());
    }
    chain.tries_[row] = *total;
  }
  if (auto ok = check_choices(chain); !ok) {
    return in_context("chain", ok.error());
  }
  chain.settle();
  return chain;
}

void Chain::settle() {
  starts_ = parts_.starts.empty() ? std::vector{StartShare{parts_.initial_state, 1}} : parts_.starts;
  starts_total_ = 0;
  for (const StartShare& start : starts_) {
    starts_total_ += start.count;
  }
  const NoAction& none = parts_.no_action;
  if (none.kind == NoAction::Kind::hold) {
    return;
  }
  when_none_.reserve(states());
  for (std::size_t state = 0; state < states(); ++state) {
    const std::size_t named = index_of(none.action);
    const bool has_named = none.kind == NoAction::Kind::named && !is_forbidden(state, named);
    const std::size_t first = state * actions();
    when_none_.push_back(static_cast<std::uint8_t>(
        has_named ? named
                  : worst_action(std::span(parts_.q).subspan(first, actions()),
                                 std::span<const std::uint64_t>(tries_).subspan(first, actions()))));
  }
}

bool Chain::is_terminal(std::size_t state) const {
  return std::binary_search(parts_.terminals.begin(), parts_.terminals.end(), static_cast<std::uint32_t>(state));
}

std::span<const std::uint8_t> Chain::features_of(std::size_t state) const {
  const std::size_t width = parts_.vocabulary.features.size();
  return std::span<const std::uint8_t>(parts_.features).subspan(state * width, width);
}

std::span<const std::uint32_t> Chain::successors(std::size_t row) const {
  const std::uint64_t begin = parts_.row_begin[row];
  return std::span<const std::uint32_t>(parts_.successor).subspan(begin, parts_.row_begin[row + 1] - begin);
}

std::span<const std::uint32_t> Chain::counts(std::size_t row) const {
  const std::uint64_t begin = parts_.row_begin[row];
  return std::span<const std::uint32_t>(parts_.count).subspan(begin, parts_.row_begin[row + 1] - begin);
}

double Chain::mean_reward(std::size_t row) const {
  return tries_[row] == 0 ? 0.0 : parts_.reward_sum[row] / static_cast<double>(tries_[row]);
}

std::size_t worst_action(std::span<const double> q, std::span<const std::uint64_t> tries) {
  COPPICE_CHECK(q.size() == tries.size());
  std::size_t worst = q.size();
  for (std::size_t action = 0; action < q.size(); ++action) {
    if (tries[action] > 0 && (worst == q.size() || q[action] < q[worst])) {
      worst = action;
    }
  }
  return worst;
}

std::vector<ActionId> greedy_policy(std::span<const double> q, std::size_t actions) {
  COPPICE_CHECK(actions > 0 && q.size() % actions == 0);
  std::vector<ActionId> policy;
  policy.reserve(q.size() / actions);
  for (std::size_t begin = 0; begin < q.size(); begin += actions) {
    const auto row = q.subspan(begin, actions);
    const auto best = std::max_element(row.begin(), row.end());
    policy.push_back(ActionId{static_cast<std::uint8_t>(best - row.begin())});
  }
  return policy;
}

}  // namespace coppice
