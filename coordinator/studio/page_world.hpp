// Walks to look at: where tree and policy go in the room, whole episodes, and the motions that the thesis shows
// (Figures 10 to 17: trash on the right, a corner, a wall), found in what was simulated. Where a study has no grid,
// a walk through its chain, state by state. The same settings give the same walks, which are those that are scored.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/learning/world.hpp"

namespace coppice {

// At most so many cells are looked at while episodes are traced, which bounds time and memory in large rooms.
inline constexpr std::uint64_t kMostTracedCells = 200'000'000;

// Grid, visits a cell, replays. Nothing there (null): the world has no grid. Fields: README.md, "world".
// Errors: interrupted.
Result<nlohmann::ordered_json> world_json(const World& world, const Chain& chain, const Tree& tree,
                                          const SimulateSettings& settings, const SimulateProgress& go_on);

// The steps around the first in which the tree, in the simulated episodes, sees just this: an entry of "replays". Null:
// it never does, or the world has no grid. REQUIRES: features of the vocabulary. Errors: interrupted.
Result<nlohmann::ordered_json> replay_to(const World& world, const Chain& chain, const Tree& tree,
                                         const SimulateSettings& settings, const std::vector<std::uint8_t>& features,
                                         const SimulateProgress& go_on);

// One walk of the tree through the chain and one of the policy. Fields: README.md, "walks".
nlohmann::ordered_json walks_json(const Chain& chain, const Tree& tree, std::uint32_t steps, std::uint64_t seed);

}  // namespace coppice
