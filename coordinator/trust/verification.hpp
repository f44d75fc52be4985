// What a tree promises on a chain: probabilities and expected values of the walk that it makes, computed exactly
// (common/chain/exact.hpp, exact_events.hpp), each with an interval for what the counts leave open.
//
// Interval: the counted rows under the tree are drawn again from their posterior (common/chain/count_posterior.hpp),
// every figure is solved anew, and the 2.5 % and 97.5 % quantiles over the draws are its bounds. That is the
// uncertainty of counting alone. It does not hold what the model leaves out: that observations which look alike may
// differ (the chain is Markov, the room is not), and that mean rewards are taken as recorded. The simulator's figures
// beside them show that. Nor does it hold successors that learning never saw, so it is too narrow where learning was
// short: Verification::intervals_too_narrow().
//
// Probabilities of events are those before the walk leaves the learned model (exact_events.hpp); rewards follow the
// chain's rule of roll-outs, in which a pair that was never tried leads to every state alike.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/trust/events.hpp"

namespace coppice {

inline constexpr std::uint32_t kFewestResamples = 20;
inline constexpr std::uint32_t kMostResamples = 100'000;

struct VerifySettings {
  std::uint32_t steps = 150;      // of an episode
  std::uint32_t resamples = 200;  // draws behind an interval
  std::uint64_t seed = 1;         // of the draws
};

// Error: a number out of range, by its flag.
Result<void> check_settings(const VerifySettings& settings);

struct Figure {
  double value = 0.0;  // from the counts as they are
  double low = 0.0;    // 95 % interval; holds value
  double high = 0.0;
};

struct EventFigures {
  std::string name;
  std::string test;             // "reward<=-10"; of leaving the model: what counts as that
  std::size_t pairs = 0;        // of the chain that are the event
  std::size_t unclear = 0;      // whose recorded reward does not tell
  Figure within;                // probability within an episode
  std::optional<Figure> ever;   // nothing: the chain is too large to be solved
  std::optional<Figure> steps;  // until it happens, of the walks in which it does; nothing: it never does
};

// Above this chance that an episode comes to what learning never saw, the intervals are called too narrow: they are
// about what was counted, and leave out what follows there. With a hundredth of the default learning (chance 0.42 for
// the default room's tree of seed 28; 0.02 with all of it) 77 to 88 % of them held the truth, not 95 %.
inline constexpr double kTooOftenUnseen = 0.1;

struct Verification {
  VerifySettings settings;
  std::size_t states = 0;                 // of the chain
  std::size_t reached = 0;                // by the walk
  Figure reward;                          // per episode
  double policy_reward = 0.0;             // the same of the policy, from the counts as they are
  std::optional<double> most_reward;      // that any policy can earn (best_return()); nothing: too large a chain
  std::optional<Figure> reward_per_step;  // in the long run
  std::vector<EventFigures> events;
  EventFigures untried;  // takes an action that learning never tried in that state
  EventFigures unseen;   // that, or comes to a successor that learning never saw there (estimated: missing_mass())

  bool intervals_too_narrow() const { return unseen.within.value > kTooOftenUnseen; }
};

// `go_on` is asked between draws; false ends it with an error (interrupted). May be empty.
// REQUIRES: check_settings(), check_tree(tree, chain.vocabulary()).
Result<Verification> verify(const Chain& chain, const Tree& tree, const std::vector<Event>& events,
                            const std::vector<double>& world_rewards, const VerifySettings& settings,
                            const std::function<bool(std::uint32_t draws_done)>& go_on);

// The same questions asked of the simulator, as far as it records them.
struct Simulated {
  std::uint64_t episodes = 0;
  Figure collision;  // share of the episodes with a collision, Wilson's interval
  Figure unknown;    // share of the episodes that met a state which the chain does not know, Wilson's interval
  Figure reward;     // per episode, normal interval
};
// REQUIRES: records are not empty.
Simulated sum_up(const std::vector<EpisodeRecord>& records);

// Wilson, "Probable inference, the law of succession, and statistical inference", JASA 1927; 95 %.
Figure wilson(std::uint64_t successes, std::uint64_t trials);

}  // namespace coppice
