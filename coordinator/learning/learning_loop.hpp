// The learning loop: one agent, one simulator, one pass that learns Q and counts the chain (thesis Algorithm 2).
// Templated on the simulator and the algorithm so that a step is straight-line code; learn.cpp is the only one to
// instantiate it. State indices are given in the order of first visit, so the first start of the first episode is
// state 0.
//
// A step that ends an episode is worth its reward alone. In the chain it leads to where the next episode starts: the
// walk renews itself, and the goal, in which nobody acts, is not a state.
//
// Owns the Q-table and the counts; one thread.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "common/chain/bytes.hpp"
#include "common/chain/chain_builder.hpp"
#include "common/chain/random.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/learning/outcome.hpp"
#include "coordinator/learning/simulators.hpp"

namespace coppice {

// Simulator: see simulators.hpp. One with kCollisionsAreCounted has them counted in the chain, pair by pair.
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
    start_ = draw_start(simulator_.starts(), random_);
    tally_.curve.episodes_per_point =
        (settings_.episodes + settings_.greedy_episodes + kCurvePoints - 1) / kCurvePoints;
  }

  // That many episodes more, at most to the last.
  void advance(std::uint64_t episodes);

  // To the last episode. Error: interrupted; then save() says where.
  Result<Learned> run(const LearnProgress& progress);

  LearnCheckpoint save() const;
  // Error (bad_input): not a state of this loop. REQUIRES: nothing was learned yet.
  Result<void> restore(const LearnCheckpoint& checkpoint);

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

  static constexpr bool kCountsCollisions = requires { Simulator::kCollisionsAreCounted; };
  static constexpr std::size_t kCollisionWidth = kCountsCollisions ? Simulator::kActions : 0;  // of a state

  // What is known of all episodes so far. Copied byte by byte into a checkpoint, but for the curve.
  struct Sums {
    std::uint64_t episodes = 0;
    std::uint64_t steps = 0;
    std::uint64_t collisions = 0;
    std::uint64_t last_collision_episode = 0;
    std::uint64_t last_change_episode = 0;
    std::uint64_t point_collisions = 0;  // since the curve's last point, as point_reward
    double reward = 0.0;                 // of the last kRewardEpisodes
    double largest_change = 0.0;
    double point_reward = 0.0;
  };
  struct Tally {
    Sums sums = {};
    LearningCurve curve = {};
  };

  struct Episode {
    double reward = 0.0;
    double largest_change = 0.0;
    std::uint64_t steps = 0;
    std::uint64_t collisions = 0;
  };

  Episode run_episode(std::uint64_t explore_below);
  void add(const Episode& episode);
  Result<Chain> make_chain() const;
  void set_starts(ChainParts& parts) const;

  std::uint32_t state_of(std::uint32_t code) {
    const std::uint32_t state = state_of_code_[code];
    return state != kUnseen ? state : first_visit(code);
  }

  std::uint32_t first_visit(std::uint32_t code) {
    const auto state = static_cast<std::uint32_t>(code_of_state_.size());
    state_of_code_[code] = state;
    code_of_state_.push_back(code);
    rows_.emplace_back();
    collisions_.resize(rows_.size() * kCollisionWidth, 0);
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
  std::vector<std::uint32_t> collisions_;     // [states x kCollisionWidth]
  std::uint32_t start_ = 0;                   // of the next episode
  // With several starts: how many episodes started in a state. Starts may look alike.
  std::map<std::uint32_t, std::uint32_t> started_;
  Tally tally_;
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
  bool ended = false;
  simulator_.reset(start_);
  std::uint32_t code = simulator_.code();
  std::uint32_t state = state_of(code);
  if (simulator_.starts() > 1) {
    ++started_[state];
  }
  std::uint8_t action = choose(code, explore_below, random);
  while (step < steps) {
    const Outcome outcome = simulator_.step(action, random);
    if (outcome.ended) {
      start_ = draw_start(simulator_.starts(), random);
      simulator_.reset(start_);
    }
    const std::uint32_t next_code = simulator_.code();
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
    if constexpr (kCountsCollisions) {
      collisions_[state * kCollisionWidth + action] += outcome.collided ? 1 : 0;
    }
    if (outcome.ended) {
      ended = true;
      break;
    }
    code = next_code;
    state = next;
    action = next_action;
  }
  if (!ended) {
    start_ = draw_start(simulator_.starts(), random);
  }
  random_ = random;
  return {reward, largest_change, step, collisions};
}

template <typename Simulator, Algorithm kAlgorithm>
void LearningLoop<Simulator, kAlgorithm>::add(const Episode& episode) {
  const std::uint64_t episodes = settings_.episodes + settings_.greedy_episodes;
  Sums& sums = tally_.sums;
  LearningCurve& curve = tally_.curve;
  const std::uint64_t k = ++sums.episodes;
  sums.steps += episode.steps;
  sums.collisions += episode.collisions;
  sums.last_collision_episode = episode.collisions > 0 ? k : sums.last_collision_episode;
  sums.last_change_episode = episode.largest_change >= kConvergedChange ? k : sums.last_change_episode;
  sums.reward += k + kRewardEpisodes > episodes ? episode.reward : 0.0;
  sums.largest_change = episode.largest_change;
  sums.point_reward += episode.reward;
  sums.point_collisions += episode.collisions;
  if (const std::uint64_t rest = k % curve.episodes_per_point; rest == 0 || k == episodes) {
    const auto of_point = static_cast<double>(rest == 0 ? curve.episodes_per_point : rest);
    curve.reward.push_back(sums.point_reward / of_point);
    curve.collisions.push_back(static_cast<double>(sums.point_collisions) / of_point);
    sums.point_reward = 0.0;
    sums.point_collisions = 0;
  }
}

template <typename Simulator, Algorithm kAlgorithm>
void LearningLoop<Simulator, kAlgorithm>::advance(std::uint64_t episodes) {
  const std::uint64_t last = std::min(tally_.sums.episodes + episodes, settings_.episodes + settings_.greedy_episodes);
  while (tally_.sums.episodes < last) {
    const double epsilon = exploration(settings_, tally_.sums.episodes + 1);
    const std::uint64_t explore_below =
        epsilon < 1.0 ? static_cast<std::uint64_t>(epsilon * 0x1.0p64) : std::numeric_limits<std::uint64_t>::max();
    add(run_episode(explore_below));
  }
}

template <typename Simulator, Algorithm kAlgorithm>
Result<Learned> LearningLoop<Simulator, kAlgorithm>::run(const LearnProgress& progress) {
  const std::uint64_t episodes = settings_.episodes + settings_.greedy_episodes;
  const auto start = Clock::now();
  auto reported = start;
  Sums& sums = tally_.sums;
  while (sums.episodes < episodes) {
    advance(kEpisodesPerClockRead);
    if (progress && sums.episodes < episodes) {
      const auto now = Clock::now();
      if (now - reported >= kProgressEvery) {
        reported = now;
        if (!progress(sums.episodes)) {
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
                 sums.steps,
                 seconds,
                 sums.reward / static_cast<double>(std::min(episodes, kRewardEpisodes)),
                 sums.largest_change,
                 sums.collisions,
                 sums.last_collision_episode,
                 sums.last_change_episode,
                 std::move(tally_.curve)};
}

// A single start needs no shares.
template <typename Simulator, Algorithm kAlgorithm>
void LearningLoop<Simulator, kAlgorithm>::set_starts(ChainParts& parts) const {
  parts.initial_state = 0;
  if (started_.size() > 1) {
    parts.initial_state = started_.begin()->first;
    for (const auto& [state, episodes] : started_) {
      parts.starts.push_back({state, episodes});
    }
  }
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
  parts.collisions = collisions_;
  set_starts(parts);
  return Chain::make(std::move(parts));
}

// The state as bytes, in the order of save(). greedy_of_code_ and state_of_code_ follow from the rest.
template <typename Simulator, Algorithm kAlgorithm>
LearnCheckpoint LearningLoop<Simulator, kAlgorithm>::save() const {
  ByteWriter writer;
  writer.put(tally_.sums);
  writer.put(random_.state());
  writer.put(start_);
  writer.put(static_cast<std::uint32_t>(rows_.size()));
  writer.put(static_cast<std::uint32_t>(started_.size()));
  const std::vector<ChainBuilder::Counted> counted = counts_.counted();
  writer.put(static_cast<std::uint64_t>(counted.size()));
  writer.put(static_cast<std::uint32_t>(tally_.curve.reward.size()));
  writer.put_all(code_of_state_);
  for (const Row& row : rows_) {
    writer.put(row);
  }
  writer.put_all(collisions_);
  for (const auto& [state, episodes] : started_) {
    writer.put(state);
    writer.put(episodes);
  }
  writer.put_all(counted);
  writer.put_all(tally_.curve.reward);
  writer.put_all(tally_.curve.collisions);
  return {tally_.sums.episodes, writer.take()};
}

template <typename Simulator, Algorithm kAlgorithm>
Result<void> LearningLoop<Simulator, kAlgorithm>::restore(const LearnCheckpoint& checkpoint) {
  const auto wrong = [](const char* what) {
    return bad_input(fmt::format("the state of learning {}: expected one that this world and algorithm wrote", what));
  };
  ByteReader reader(checkpoint.state);
  tally_.sums = reader.template get<Sums>();
  const auto random = Xoshiro256::from_state(reader.template get<std::array<std::uint64_t, 4>>());
  start_ = reader.template get<std::uint32_t>();
  const auto states = reader.template get<std::uint32_t>();
  const auto started = reader.template get<std::uint32_t>();
  const auto counted = reader.template get<std::uint64_t>();
  const auto points = reader.template get<std::uint32_t>();
  code_of_state_ = reader.template get_all<std::uint32_t>(states);
  rows_ = reader.template get_all<Row>(states);
  collisions_ = reader.template get_all<std::uint32_t>(std::size_t{states} * kCollisionWidth);
  for (std::uint32_t i = 0; i < started && reader.ok(); ++i) {
    const auto state = reader.template get<std::uint32_t>();
    started_[state] = reader.template get<std::uint32_t>();
  }
  const auto transitions = reader.template get_all<ChainBuilder::Counted>(counted);
  tally_.curve.reward = reader.template get_all<double>(points);
  tally_.curve.collisions = reader.template get_all<double>(points);
  if (!reader.ok() || reader.left() != 0) {
    return wrong("has another length");
  }
  if (!random || start_ >= simulator_.starts() || tally_.sums.episodes != checkpoint.episodes_done ||
      tally_.sums.episodes > settings_.episodes + settings_.greedy_episodes ||
      std::any_of(started_.begin(), started_.end(), [&](const auto& start) { return start.first >= states; })) {
    return wrong("has numbers out of range");
  }
  random_ = *random;
  for (std::uint32_t state = 0; state < states; ++state) {
    const std::uint32_t code = code_of_state_[state];
    if (code >= Simulator::kCodes || state_of_code_[code] != kUnseen) {
      return wrong("names an observation twice, or one that there is not");
    }
    state_of_code_[code] = state;
    greedy_of_code_[code] = greedy(rows_[state]);
  }
  for (const ChainBuilder::Counted& transition : transitions) {
    if (transition.row >= std::uint64_t{states} * Simulator::kActions || transition.next >= states ||
        !counts_.add(transition)) {
      return wrong("counts a transition twice, or one that there is not");
    }
  }
  return {};
}

}  // namespace coppice
