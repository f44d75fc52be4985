#include "coordinator/refine/experience.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {
namespace {

std::string key_of(std::span<const std::uint8_t> observation) { return {observation.begin(), observation.end()}; }

// One row's successors with their counts, ascending.
struct Row {
  std::span<const std::uint32_t> successor;
  std::span<const std::uint32_t> count;
};

Row row_of(const ChainParts& parts, std::size_t row) {
  const std::uint64_t begin = parts.row_begin[row];
  const std::uint64_t size = parts.row_begin[row + 1] - begin;
  return {std::span(parts.successor).subspan(begin, size), std::span(parts.count).subspan(begin, size)};
}

// Appends the sum of two rows. Returns how many successors only `added` has. Errors: a count of 2^32 or more.
Result<std::size_t> append_sum(const Row& known, const Row& added, ChainParts& parts) {
  std::size_t fresh = 0;
  std::size_t k = 0;
  for (std::size_t a = 0; a < added.successor.size(); ++a) {
    for (; k < known.successor.size() && known.successor[k] < added.successor[a]; ++k) {
      parts.successor.push_back(known.successor[k]);
      parts.count.push_back(known.count[k]);
    }
    std::uint64_t count = added.count[a];
    if (k < known.successor.size() && known.successor[k] == added.successor[a]) {
      count += known.count[k++];
    } else {
      ++fresh;
    }
    if (count >> 32U != 0) {
      return bad_input("a transition was counted 2^32 times or more: expected fewer episodes");
    }
    parts.successor.push_back(added.successor[a]);
    parts.count.push_back(static_cast<std::uint32_t>(count));
  }
  for (; k < known.successor.size(); ++k) {
    parts.successor.push_back(known.successor[k]);
    parts.count.push_back(known.count[k]);
  }
  parts.row_begin.push_back(parts.successor.size());
  return fresh;
}

}  // namespace

Experience::Experience(const Chain& chain)
    : chain_(chain),
      states_(static_cast<std::uint32_t>(chain.states())),
      reward_sum_(chain.states() * chain.actions(), 0.0),
      collisions_(chain.parts().collisions.empty() ? 0 : chain.states() * chain.actions(), 0),
      counts_(chain.actions()) {
  state_of_.reserve(chain.states());
  for (std::uint32_t state = 0; state < chain.states(); ++state) {
    if (!chain.is_terminal(state)) {
      state_of_.emplace(key_of(chain.features_of(state)), state);
    }
  }
}

std::uint32_t Experience::state_of(std::span<const std::uint8_t> observation) {
  const auto [found, fresh] = state_of_.emplace(key_of(observation), states_);
  if (fresh) {
    ++states_;
    new_features_.insert(new_features_.end(), observation.begin(), observation.end());
    reward_sum_.resize(reward_sum_.size() + chain_.actions(), 0.0);
    collisions_.resize(chain_.parts().collisions.empty() ? 0 : reward_sum_.size(), 0);
  }
  return found->second;
}

std::uint32_t Experience::end_of(std::span<const std::uint8_t> observation) {
  const std::vector<std::uint32_t>& ends = chain_.parts().terminals;
  const auto alike = std::find_if(ends.begin(), ends.end(), [&](std::uint32_t state) {
    const auto features = chain_.features_of(state);
    return std::equal(features.begin(), features.end(), observation.begin(), observation.end());
  });
  return alike != ends.end() ? *alike : !ends.empty() ? ends.front() : state_of(observation);
}

void Experience::add(const SimulatedStep& step) {
  COPPICE_CHECK(step.action != kNoAction && index_of(step.action) < chain_.actions());
  const std::uint32_t state = state_of(step.before);
  const std::uint32_t next = step.ended ? end_of(step.after) : state_of(step.after);
  counts_.count(state, static_cast<std::uint32_t>(index_of(step.action)), next);
  reward_sum_[chain_.row(state, step.action)] += step.reward;
  if (!collisions_.empty()) {
    collisions_[chain_.row(state, step.action)] += step.collided.value_or(false) ? 1 : 0;
    lacks_collisions_ = lacks_collisions_ || !step.collided;
  }
  ++steps_;
}

Result<Extended> Experience::extended() const {
  if (lacks_collisions_) {
    return bad_input(
        "the study counts collisions, and the simulator does not say which steps are some: expected \"collisions\": "
        "true "
        "in its first line (python -m coppice.gym --collision-reward R)");
  }
  const ChainParts& known = chain_.parts();
  const std::size_t states = states_;
  const std::size_t known_rows = chain_.states() * chain_.actions();
  const std::size_t rows = states * chain_.actions();
  ChainParts added;
  if (auto ok = counts_.fill(states, added); !ok) {
    return tl::unexpected(ok.error());
  }
  ChainParts parts = known;
  parts.features.insert(parts.features.end(), new_features_.begin(), new_features_.end());
  // A new state may look like one that ends episodes: what was observed there went on.
  parts.look_alikes = parts.look_alikes || (!parts.terminals.empty() && states > chain_.states());
  parts.reward_sum.resize(rows, 0.0);
  parts.q.resize(rows, 0.0);
  parts.policy.resize(states, greedy_policy(std::vector<double>(chain_.actions(), 0.0), chain_.actions()).front());
  parts.visits.resize(states, 0);
  parts.forbidden.resize(parts.forbidden.empty() ? 0 : rows, 0);
  parts.collisions.resize(parts.collisions.empty() ? 0 : rows, 0);
  parts.row_begin = {0};
  parts.successor.clear();
  parts.count.clear();
  Gains gains{.steps = steps_, .states = states - chain_.states()};
  for (std::size_t row = 0; row < rows; ++row) {
    const Row before = row < known_rows ? row_of(known, row) : Row{};
    const Row more = row_of(added, row);
    const auto fresh = append_sum(before, more, parts);
    if (!fresh) {
      return tl::unexpected(fresh.error());
    }
    gains.transitions += *fresh;
    gains.pairs += before.successor.empty() && !more.successor.empty() ? 1 : 0;
    parts.reward_sum[row] += reward_sum_[row];
    if (!collisions_.empty()) {  // no more than the row's tries, which stay below 2^32 or Chain::make() refuses
      parts.collisions[row] += static_cast<std::uint32_t>(collisions_[row]);
    }
  }
  auto chain = Chain::make(std::move(parts));
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  return Extended{std::move(*chain), gains};
}

}  // namespace coppice
