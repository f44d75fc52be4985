// The learning loop: one agent, one simulator, one pass that learns Q and counts the chain (thesis Algorithm 2).
// Templated on the simulator and the algorithm so that a step is straight-line code; learn.cpp is the only one to
// instantiate it. State indices are given in the order of first visit, so the world's initial state is state 0.
//
// A step that ends an episode is worth its reward alone. In the chain it leads to state 0, where the next episode
// starts: the walk renews itself, and the goal, in which nobody acts, is not a state.
//
// Owns the Q-table and the counts; one thread.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/chain/chain_builder.hpp"
#include "common/chain/random.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/learning/outcome.hpp"

namespace coppice {

// Simulator: kActions, kCodes, vocabulary(), features_of(code, features), reset(), code(), step(action, random).
template <typename Simulator, Algorithm kAlgorithm>
class LearningLoop {
 public:
  // REQUIRES: check_settings(settings).
  LearningLoop(Simulator simulator, const LearnSettings& settings)
      : simulator_(std::move(simulator)),
        settings_(settings),
        random_(settings.seed),
        counts_(Simulator::kActions),
        state_of_code_(Simulator::kCodes, kUnseen),
        greedy_of_code_(Simulator::kCodes, 0) {
    rows_.reserve(Simulator::kCodes);
  }

  Result<Learned> run(const LearnProgress& progress);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::uint32_t kUnseen = 0xFFFFFFFF;
  static constexpr std::uint64_t kEpisodesPerClockRead = 64;
  static constexpr std::chrono::milliseconds kProgressEvery{100};
  static constexpr std::uint64_t kRewardEpisodes = 1000;  // at the end, over which last_rewards is the mean

  // Everything that a step in one state touches, in one cache line.
  static constexpr std::size_t kWidth = 4;
  static_assert(Simulator::kActions <= kWidth);
  struct alignas(64) Row {
    std::array<double, kWidth> q{};
    std::array<double, kWidth> reward_sum{};
  };

  struct Episode {
    double reward = 0.0;
    double largest_change = 0.0;
    std::uint64_t steps = 0;
    std::uint64_t collisions = 0;
  };

  Episode run_episode(std::uint64_t explore_below);
  Result<Chain> make_chain() const;

  std::uint32_t state_of(std::uint32_t code) {
    const std::uint32_t state = state_of_code_[code];
    return state != kUnseen ? state : first_visit(code);
  }

  std::uint32_t first_visit(std::uint32_t code) {
    const auto state = static_cast<std::uint32_t>(code_of_state_.size());
    state_of_code_[code] = state;
    code_of_state_.push_back(code);
    rows_.emplace_back();
    return state;
  }

  // Ties go to the lowest index, as in greedy_policy().
  static std::uint8_t greedy(const Row& row) {
    std::uint32_t best = 0;
    double value = row.q[0];
    for (std::uint32_t action = 1; action < Simulator::kActions; ++action) {
      const std::uint32_t higher = row.q[action] > value ? ~0U : 0U;  // a mask: the compiler would branch
      best = (best & ~higher) | (action & higher);
      value = std::max(value, row.q[action]);
    }
    return static_cast<std::uint8_t>(best);
  }

  static double highest(const Row& row) {
    double value = row.q[0];
    for (std::size_t action = 1; action < Simulator::kActions; ++action) {
      value = std::max(value, row.q[action]);
    }
    return value;
  }

  std::uint8_t choose(std::uint32_t code, std::uint64_t explore_below, Xoshiro256& random) {
    const std::uint8_t best = greedy_of_code_[code];
    if (random.next() < explore_below) [[unlikely]] {
      const auto other = static_cast<std::uint8_t>(random.below(Simulator::kActions - 1));
      return static_cast<std::uint8_t>(other + (other >= best ? 1 : 0));
    }
    return best;
  }

  // The next step waits only for the observation and this table, not for the arithmetic on Q, as long as the table is
  // written only when the greedy action changes, which is rare.
  void remember_greedy(std::uint32_t code, const Row& row) {
    const std::uint8_t best = greedy(row);
    if (best != greedy_of_code_[code]) [[unlikely]] {
      greedy_of_code_[code] = best;
    }
  }

  Simulator simulator_;
  LearnSettings settings_;
  Xoshiro256 random_;
  ChainBuilder counts_;
  std::vector<std::uint32_t> state_of_code_;  // [codes] kUnseen, or the state's index
  std::vector<std::uint8_t> greedy_of_code_;  // [codes] the greedy action
  std::vector<std::uint32_t> code_of_state_;  // [states]
  std::vector<Row> rows_;                     // [states]
};

template <typename Simulator, Algorithm kAlgorithm>
auto LearningLoop<Simulator, kAlgorithm>::run_episode(std::uint64_t explore_below) -> Episode {
  const double alpha = settings_.alpha;
  const double keep = 1.0 - alpha;
  const double gamma = settings_.gamma;
  const std::uint32_t steps = settings_.steps;
  // Locals, so that they can live in registers.
  Xoshiro256 random = random_;
  double reward = 0.0;
  double largest_change = 0.0;
  std::uint64_t collisions = 0;
  std::uint32_t step = 0;
  simulator_.reset();
  std::uint32_t code = simulator_.code();
  std::uint32_t state = state_of(code);
  std::uint8_t action = choose(code, explore_below, random);
  while (step < steps) {
    const Outcome outcome = simulator_.step(action, random);
    const std::uint32_t next_code = outcome.ended ? code_of_state_[0] : simulator_.code();
    const std::uint32_t next = state_of(next_code);
    std::uint8_t next_action = 0;
    double future = 0.0;
    if constexpr (kAlgorithm == Algorithm::sarsa) {
      next_action = choose(next_code, explore_below, random);
      future = rows_[next].q[next_action];
    } else {
      future = highest(rows_[next]);
    }
    Row& row = rows_[state];
    const double before = row.q[action];
    const double after = keep * before + alpha * (outcome.reward + gamma * (outcome.ended ? 0.0 : future));
    row.q[action] = after;
    row.reward_sum[action] += outcome.reward;
    remember_greedy(code, row);
    counts_.count(state, action, next);
    if constexpr (kAlgorithm == Algorithm::q_learning) {
      next_action = choose(next_code, explore_below, random);
    }
    ++step;
    reward += outcome.reward;
    largest_change = std::max(largest_change, std::abs(after - before));
    collisions += outcome.collided ? 1 : 0;
    if (outcome.ended) {
      break;
    }
    code = next_code;
    state = next;
    action = next_action;
  }
  random_ = random;
  return {reward, largest_change, step, collisions};
}

template <typename Simulator, Algorithm kAlgorithm>
Result<Learned> LearningLoop<Simulator, kAlgorithm>::run(const LearnProgress& progress) {
  const std::uint64_t episodes = settings_.episodes + settings_.greedy_episodes;
  const std::uint64_t rewards_from = episodes - std::min(episodes, kRewardEpisodes) + 1;
  const auto start = Clock::now();
  auto reported = start;
  std::uint64_t steps = 0;
  std::uint64_t collisions = 0;
  std::uint64_t last_collision_episode = 0;
  std::uint64_t last_change_episode = 0;
  double reward = 0.0;
  double largest_change = 0.0;
  LearningCurve curve{
      .episodes_per_point = (episodes + kCurvePoints - 1) / kCurvePoints, .reward = {}, .collisions = {}};
  double point_reward = 0.0;
  std::uint64_t point_collisions = 0;
  for (std::uint64_t k = 1; k <= episodes; ++k) {
    const double epsilon = exploration(settings_, k);
    const std::uint64_t explore_below =
        epsilon < 1.0 ? static_cast<std::uint64_t>(epsilon * 0x1.0p64) : std::numeric_limits<std::uint64_t>::max();
    const Episode episode = run_episode(explore_below);
    steps += episode.steps;
    collisions += episode.collisions;
    last_collision_episode = episode.collisions > 0 ? k : last_collision_episode;
    last_change_episode = episode.largest_change >= kConvergedChange ? k : last_change_episode;
    reward += k >= rewards_from ? episode.reward : 0.0;
    largest_change = episode.largest_change;
    point_reward += episode.reward;
    point_collisions += episode.collisions;
    if (const std::uint64_t rest = k % curve.episodes_per_point; rest == 0 || k == episodes) {
      const auto of_point = static_cast<double>(rest == 0 ? curve.episodes_per_point : rest);
      curve.reward.push_back(point_reward / of_point);
      curve.collisions.push_back(static_cast<double>(point_collisions) / of_point);
      point_reward = 0.0;
      point_collisions = 0;
    }
    if (k % kEpisodesPerClockRead == 0 && progress) {
      const auto now = Clock::now();
      if (now - reported >= kProgressEvery) {
        reported = now;
        if (!progress(k)) {
          return tl::unexpected(Error{ErrorKind::interrupted, "learning was stopped before its last episode"});
        }
      }
    }
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  auto chain = make_chain();
  if (!chain) {
    return tl::unexpected(chain.error());
  }
  return Learned{std::move(*chain),
                 steps,
                 seconds,
                 reward / static_cast<double>(episodes - rewards_from + 1),
                 largest_change,
                 collisions,
                 last_collision_episode,
                 last_change_episode,
                 std::move(curve)};
}

template <typename Simulator, Algorithm kAlgorithm>
Result<Chain> LearningLoop<Simulator, kAlgorithm>::make_chain() const {
  constexpr std::size_t kActions = Simulator::kActions;
  const std::size_t states = rows_.size();
  ChainParts parts;
  parts.vocabulary = Simulator::vocabulary();
  const std::size_t width = parts.vocabulary.features.size();
  parts.features.resize(states * width);
  parts.visits.assign(states, 0);
  if (auto ok = counts_.fill(states, parts); !ok) {
    return tl::unexpected(ok.error());
  }
  for (std::size_t state = 0; state < states; ++state) {
    Simulator::features_of(code_of_state_[state], std::span(parts.features).subspan(state * width, width));
    const auto copied = static_cast<std::ptrdiff_t>(kActions);
    parts.q.insert(parts.q.end(), rows_[state].q.begin(), rows_[state].q.begin() + copied);
    parts.reward_sum.insert(parts.reward_sum.end(), rows_[state].reward_sum.begin(),
                            rows_[state].reward_sum.begin() + copied);
    for (std::uint64_t i = parts.row_begin[state * kActions]; i < parts.row_begin[(state + 1) * kActions]; ++i) {
      parts.visits[state] += parts.count[i];
    }
  }
  parts.policy = greedy_policy(parts.q, kActions);
  parts.initial_state = 0;
  return Chain::make(std::move(parts));
}

}  // namespace coppice
