// What can happen to an agent, told by what the chain keeps. A chain records for each (state, action) pair the
// successors and the summed reward, not what happened. So an event is told by the reward: a pair is an event if its
// mean recorded reward passes a test. Where a world gives each thing that can happen a reward of its own, and the test
// is for the lowest or the highest of them, that is exact: a mean of -10 where nothing is worse than -10 says that
// every try gave -10. A mean strictly between tells nothing; such pairs are counted (`unclear`), never guessed at.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "coordinator/learning/world.hpp"

namespace coppice {

struct Event {
  std::string name;
  bool at_most = true;  // mean reward <= bound; else >= bound
  double bound = 0.0;
  bool counted = false;  // not told by the reward: a collision, where the chain counts them
};

// "collision:reward<=-10". Errors say what was found and what was expected.
Result<Event> parse_event(std::string_view text);
std::string to_text(const Event& event);  // "reward<=-10"; "counted"

// A room: collision (reward<=-10) and trash (reward>=20). With a battery: collision (counted), and trash. The windy
// grid: goal (reward>=9). Others: none.
std::vector<Event> events_of_world(std::string_view kind);

struct EventPairs {
  // [states x (actions + 1)], 1 where the pair is the event, else 0; of a counted event its share of the pair's tries.
  // No action never is the event.
  std::vector<double> chance;
  std::size_t pairs = 0;    // that are the event
  std::size_t unclear = 0;  // tried pairs whose mean is none of the rewards that the world gives
};

// REQUIRES: a counted event's chain counts collisions. world_rewards: all rewards that one step can give; empty if not
// known, then nothing is unclear.
EventPairs pairs_of(const Event& event, const Chain& chain, const std::vector<double>& world_rewards);
std::vector<double> rewards_of_world(std::string_view kind);

}  // namespace coppice
