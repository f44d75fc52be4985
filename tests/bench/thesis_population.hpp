// What the genetic algorithm really evaluates at the thesis' scale: the UAV's chain and trees of its populations.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"

namespace coppice::bench {

// Learned in 200,000 episodes of 150 steps; about 1000 states.
std::shared_ptr<const Chain> uav_chain();

// `count` trees with different action tables, in the order in which an evolution with the thesis' configuration met
// them, taken from every fourth generation.
std::vector<Tree> bred_trees(const std::shared_ptr<const Chain>& chain, std::size_t count);

}  // namespace coppice::bench
