// The thesis' tables about its room, from what ran on ours.
#pragma once

#include <string>
#include <vector>

#include "coordinator/reproduce/comparison.hpp"
#include "coordinator/reproduce/printed.hpp"
#include "coordinator/reproduce/trial.hpp"

namespace coppice {

// What all tables of the room speak of.
struct RoomRun {
  const Chain& chain;
  const World& world;
  std::string study;       // its file's name, for commands
  ControllerScore policy;  // the learned policy in the simulator
  double policy_q = 0.0;   // its accumulated Q along the chain
  SimulateSettings simulate;
  std::uint64_t episodes = 0;   // of learning
  std::uint32_t q_steps = 100;  // over which Q is accumulated: thesis Table III
};

// Table IV. REQUIRES (all below): trials is not empty.
Comparison table_four(const RoomRun& run, const Experiment& experiment, const std::vector<Trial>& trials);

struct TreeTable {
  std::string name;
  std::string title;
  printed::TwoColumns printed;
  std::vector<std::string> remarks;
};
// Tables 5-1, 5-2, 5-6 and 5-7 have one shape.
Comparison tree_table(const TreeTable& table, const RoomRun& run, const Experiment& experiment,
                      const std::vector<Trial>& trials);

// Tables 5-3 and 5-4: the chain itself.
Comparison table_five_three(const RoomRun& run);
Comparison table_five_four(const RoomRun& run);

// What the trials of an experiment have in common, in words: how many collide, stand still, ...
std::string remark_on_acting(const std::vector<Trial>& trials);    // Table 5-7
std::string remark_on_spinning(const std::vector<Trial>& trials);  // Table 5-6

// Table 5-8: ten runs of the tree of Table 5-7, and of the one that collides most.
Comparison table_five_eight(const RoomRun& run, const std::vector<Trial>& trials);

// The count of the discussion (VII, "Easy verification"). Errors: as check_rule().
Result<Comparison> verification_count(const RoomRun& run, const std::vector<Trial>& trials);

}  // namespace coppice
