// Learning a tabular policy and counting its chain in one pass (thesis VI-E.1 and VI-E.2, Algorithm 2).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/named.hpp"
#include "coordinator/learning/world.hpp"

namespace coppice {

enum class Algorithm : std::uint8_t { q_learning = 0, sarsa = 1 };
template <>
inline constexpr std::array kNames<Algorithm> = names("q-learning", "sarsa");

// Exploration over episodes e = 1..E with n_d = E / 100.
enum class Decay : std::uint8_t {
  thesis = 0,   // eps0 (n_d + 1) / (n_d + e): fits thesis Figure 8 and its final 0.005
  printed = 1,  // eps0 (n_d + 1) / (n_d e): thesis Equation (3) as printed
  linear = 2,   // eps0 (E - e) / (E - 1): thesis 4-1, zero in the last episode
};
template <>
inline constexpr std::array kNames<Decay> = names("thesis", "printed", "linear");

struct LearnSettings {
  Algorithm algorithm = Algorithm::q_learning;
  std::uint64_t episodes = 1'000'000;
  std::uint32_t steps = 150;  // per episode
  double alpha = 0.5;         // learning rate
  double gamma = 0.8;         // discount factor
  double epsilon = 0.5;       // exploration in the first episode
  Decay decay = Decay::thesis;
  // More episodes behind those, without exploration: thesis Table 4-1 has 200 episodes and SARSA converge in episode
  // 269.
  std::uint64_t greedy_episodes = 0;
  std::uint64_t seed = 1;
};

// A change of Q below this is none: "converged if delta-Q is less than 1e-8" (thesis 4-1).
inline constexpr double kConvergedChange = 1e-8;

// Thesis Table II for a room, Table 4-1 for the windy grid (whose Q-learning and SARSA discount differently). A battery
// has to be thought of long before it is empty, so there the discount is 0.95, with a learning rate of 0.1 against the
// noise that this lets in, and an episode lasts for three batteries.
// We differ: 2000 episodes on the windy grid, not 200. The thesis does not print its grid; in Sutton and Barto's, the
// goal is 15 of the 25 allowed steps away, and of seeds 1 to 8 none learned a way there within 200 or 300 episodes,
// with either algorithm; within 2000 all 16 found a shortest one.
LearnSettings default_settings(WorldKind kind, Algorithm algorithm);

// Errors name the flag (--episodes, --alpha, ...), what was found and the range.
Result<void> check_settings(const LearnSettings& settings);

// The chance of a non-greedy action in an episode, counted from 1. REQUIRES: check_settings(settings),
// 1 <= episode <= settings.episodes + settings.greedy_episodes.
double exploration(const LearnSettings& settings, std::uint64_t episode);

// How learning went, as a person looks at it: means over groups of episodes that follow each other.
inline constexpr std::uint64_t kCurvePoints = 200;
struct LearningCurve {
  std::uint64_t episodes_per_point = 1;
  std::vector<double> reward;      // [points] per episode, as it was earned, exploration included
  std::vector<double> collisions;  // [points] per episode
};

struct Learned {
  Chain chain;
  std::uint64_t steps = 0;       // taken in all
  double seconds = 0.0;          // of the learning loop alone
  double last_rewards = 0.0;     // mean reward per episode over the last 1000 episodes (or all, if fewer)
  double largest_change = 0.0;   // |change of Q| in the last episode, largest (thesis Figures 4-3 and 15)
  std::uint64_t collisions = 0;  // over all episodes
  std::uint64_t last_collision_episode = 0;
  std::uint64_t last_change_episode = 0;  // the last with a change of Q of kConvergedChange or more
  LearningCurve curve = {};
};

// Called about every 100 ms at most, between episodes; returns false to stop.
using LearnProgress = std::function<bool(std::uint64_t episodes_done)>;

// Where learning stands between two episodes: all that it takes to go on to the same bits.
struct LearnCheckpoint {
  std::uint64_t episodes_done = 0;
  std::vector<std::uint8_t> state;  // for learn() alone to read
};

// The same world, settings and seed give the same chain, bit for bit, however often learning was interrupted. Errors:
// bad settings; interrupted when `progress` returned false.
// checkpoint, if given: where to go on from, unless it is empty, and where learning was interrupted. Error (bad_input):
// one that is damaged, or of another world or algorithm.
Result<Learned> learn(const World& world, const LearnSettings& settings, const LearnProgress& progress,
                      LearnCheckpoint* checkpoint = nullptr);

}  // namespace coppice
