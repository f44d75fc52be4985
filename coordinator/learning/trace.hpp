// Episodes in the simulator, step by step, with the place of the agent: what a person watches. The same episodes as
// simulate_tree() and simulate_policy() walk for the same settings (simulate.hpp), so what is seen is what was scored.
// Plain values; functions without state.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/room_map.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/learning/world.hpp"

namespace coppice {

// Cells are numbered in reading order, from 0 at the top left: cell = y * width + x.
struct Pose {
  std::uint32_t cell = 0;
  std::uint8_t heading = 0;  // as Heading; 0 where the world knows none
  bool operator==(const Pose&) const = default;
};

struct TracedStep {
  std::vector<std::uint8_t> features;  // what was observed before the step
  ActionId action = kNoAction;         // kNoAction: it held still
  Pose after{};
  double reward = 0.0;
  bool collided = false;
  // Trash that was collected in this step, at after.cell, came again here.
  std::optional<std::uint32_t> trash_moved_to{};
};

struct Trace {
  std::uint64_t episode = 0;
  Pose start{};
  std::vector<TracedStep> steps;
};

// What the world looks like when an episode begins.
struct Grid {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<Cell> cells;              // [height x width]
  std::optional<std::uint32_t> goal{};  // a cell to come to: what ends the episode, or a charger
  bool has_heading = false;
};

// Nothing: the world has no grid. REQUIRES: a world from make_world() or load_world().
std::optional<Grid> grid_of(const World& world);

// `tree`: nullptr for the learned policy. Errors: interrupted, when `go_on` said to stop. REQUIRES: as simulate_tree();
// the world has a grid.
Result<std::vector<Trace>> trace_episodes(const World& world, const Chain& chain, const Tree* tree,
                                          const SimulateSettings& settings, const SimulateProgress& go_on = {});

}  // namespace coppice
