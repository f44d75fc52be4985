// Thesis Table IV: how far a tree does what the learned policy does, over all states and in the simulator, and what it
// earns there. Margins are 95 % confidence intervals of the mean over episodes by the normal approximation,
// mean +- 1.96 s / sqrt(n), with s the sample standard deviation (n - 1) of the n episodes; an episode is one sample,
// since steps of one episode depend on each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/report/on_chain.hpp"

namespace coppice {

struct Estimate {
  double mean = 0.0;
  double margin = 0.0;  // half the width of the interval; 0 for a single sample
  bool operator==(const Estimate&) const = default;
};

// REQUIRES: samples not empty.
Estimate estimate(const std::vector<double>& samples);

// A state that was visited a few times has a policy action decided by noise.
inline constexpr std::uint64_t kSeenVisits = 1000;

struct ControllerScore {
  std::size_t matching_states = 0;  // of Score::states, where the action is the policy's
  std::size_t matching_seen = 0;    // of Score::seen_states
  std::uint64_t episodes = 0;
  std::uint64_t steps = 0;  // taken in all episodes
  Estimate agreement;       // share of an episode's steps, in [0, 1]
  Estimate reward;          // per episode
  Estimate collisions;      // per episode
  std::uint64_t total_collisions = 0;
  std::uint64_t unknown_steps = 0;  // in states that the chain does not know
};

// Along the chain, computed instead of sampled.
struct ExpectedScores {
  ExpectedScore policy;
  ExpectedScore tree;
  ExpectedScore pruned;
};

struct Score {
  WorldKind world = WorldKind::uav;
  bool thesis_room = false;  // the world is that of the thesis' figures
  SimulateSettings settings;
  std::size_t states = 0;
  std::uint64_t seen_visits = kSeenVisits;
  std::size_t seen_states = 0;   // visited seen_visits times or more in learning
  std::size_t entries = 0;       // of the Q-table: states x actions
  ControllerScore policy;        // the learned policy itself
  ControllerScore tree;          // the tree as it was given
  ControllerScore pruned;        // the tree pruned on the chain's states
  std::size_t nodes = 0;         // of the tree as it was given
  std::size_t nodes_sound = 0;   // after simplify() that holds in every possible state
  std::size_t nodes_pruned = 0;  // after simplify() that holds in the chain's states
  std::string tree_text;
  std::string pruned_text;
  std::optional<ExpectedScores> expected;  // by add_exact()
};

// Sums up the episodes of one controller. REQUIRES: episodes not empty.
ControllerScore controller_score(const std::vector<EpisodeRecord>& episodes);

// Errors name the flag: fewer than two episodes, which give no interval, or too many; steps out of range.
Result<void> check_score_settings(const SimulateSettings& settings, std::string_view episodes_flag = "--episodes");

// Simulates the policy, the tree and the pruned tree. Errors: as check_score_settings(); the chain's vocabulary is not
// the world's; interrupted when `go_on` returned false. REQUIRES: check_tree() for the chain's vocabulary.
Result<Score> score_tree(const World& world, const Chain& chain, const Tree& tree, const SimulateSettings& settings,
                         const SimulateProgress& go_on = {}, std::uint64_t seen_visits = kSeenVisits);

// Adds what is expected along the chain over settings.steps steps from its initial state, which needs no simulator:
// what the chain knows. A tree without an action holds its state and earns nothing. REQUIRES: score is of this tree on
// this chain.
void add_exact(const Chain& chain, const Tree& tree, Score& score);

// Lines of text; beside ours the figures that the thesis prints, when the world is its room.
std::string to_text(const Score& score);
// One JSON object on one line.
std::string to_json(const Score& score);

}  // namespace coppice
