// The room of the thesis, learned for 3000 episodes: enough for tests of what a run does with a chain.
#pragma once

#include <string>

#include "common/chain/chain.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/learning/rooms.hpp"

namespace coppice {

inline Chain learned_room() {
  LearnSettings learning = default_settings(WorldKind::uav, Algorithm::q_learning);
  learning.episodes = 3000;
  const auto world = make_world("uav", std::string(default_room())).value();
  return learn(world, learning, {}).value().chain;
}

}  // namespace coppice
