// Closing the loop between chain and simulator: the best tree is walked in the simulator, what it meets is counted into
// the chain, and evolution goes on there, round after round. A chain counted while the policy was learned knows best
// what the policy meets; a tree that errs goes elsewhere, where the chain has few counts, or counts from walks that
// came there another way. This is DAgger (Ross, Gordon and Bagnell, "A reduction of imitation learning and structured
// prediction to no-regret online learning", AISTATS 2011): collect what the learner itself meets, label it by the
// expert (the Q-table as learned), add it to all that was collected before, train again. Because trees are judged by
// walks through the chain, what is gathered corrects the model too, as in Ross and Bagnell, "Agnostic system
// identification for model-based reinforcement learning", ICML 2012.
//
// We differ: no mixing with the expert (their beta): the chain holds the expert's own walks already. As theirs, the
// answer is the best of all rounds by validation (best_of()), on episodes that no round walks; the figures of a round
// that was chosen for them are a little better than it deserves.
//
// Each round is a study of its own in one folder, complete or absent like any study: its chain is the round's, its run
// the round's evolution. So an interruption keeps every round before, and the best so far of the one under way. What
// comes out is a pure function of (study, tree, settings, configuration).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/refine/experience.hpp"
#include "coordinator/report/score.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

inline constexpr std::uint32_t kMostRounds = 1000;

struct RefineSettings {
  std::uint32_t rounds = 3;
  SimulateSettings walks{.episodes = 10'000};  // of each round; first_episode is set by round
  SimulateSettings judged;                     // of the score; episodes that no round walks
};
// Error: a number out of range, by its flag.
Result<void> check_settings(const RefineSettings& settings);

// Where the loop stands after a round; round 0 is the tree that it starts from, on the study's own chain.
struct RefineRound {
  std::uint32_t round = 0;
  std::uint64_t seed = 0;                     // of its evolution
  std::optional<Gains> gains = std::nullopt;  // none: round 0
  std::string study = {};                     // path
  std::string chain = {};                     // hash
  std::size_t states = 0;                     // of its chain
  // Of its tree, on its chain and in the simulator; none: interrupted.
  std::optional<Score> score = std::nullopt;
};

// What a round's evolution came to.
struct RoundAnswer {
  Tree tree{ActionId{0}};
  bool interrupted = false;
};

struct RefineHooks {
  // Evolves by this configuration in the round's study, as a run of it.
  std::function<Result<RoundAnswer>(Study& study, const EvolveConfig& config)> evolve;
  // Between episodes; false to stop. May be empty.
  SimulateProgress go_on;
  // A round begins to walk. May be empty.
  std::function<void(std::uint32_t round)> walking;
  // A round has ended, round 0 first: to be shown. May be empty.
  std::function<void(const RefineRound&)> round_done;
};

// The answer of the loop: the round whose tree collides least often in the simulator and, of those, earns most; the
// earlier of two alike. Nothing: no round was scored.
std::optional<std::size_t> best_of(const std::vector<RefineRound>& rounds);

// The study of a round, in the folder.
std::filesystem::path study_of_round(const std::filesystem::path& folder, std::uint32_t round);

// Round r evolves with seed config.seed + r and begins with the tree that was walked, the best of the rounds before
// (best_of()) and, if the walked one is on a front of its study, the trees of that front: ga.founders, as far as
// `config` allows them, beside those that `config` names. What is walked is the last round's tree, be it better or
// worse: where it errs is what the chain lacks.
// Errors: interrupted (what has ended was reported); as the simulator, the study and the hook.
// REQUIRES: check_settings(), check_config(config), check_tree(tree); the folder exists; the study's vocabulary is that
// of `world`.
Result<void> refine(const Study& study, const World& world, const Tree& tree, const EvolveConfig& config,
                    const RefineSettings& settings, const std::filesystem::path& folder, const RefineHooks& hooks);

}  // namespace coppice
