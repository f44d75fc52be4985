// Evolution: breeds trees that do what the chain's policy does (thesis Algorithm 1 and VI-E.3). The result is a pure
// function of (chain, config): chance in generation g depends on (seed, g) alone, so an evolution that is resumed from
// a checkpoint, or evaluated elsewhere, ends with the very same trees and numbers. Runs on the calling thread;
// everything costly happens behind the Evaluator.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/evolution/breeding.hpp"
#include "coordinator/evolution/config.hpp"
#include "coordinator/evolution/pick.hpp"

namespace coppice {

// The best individual of one generation, as it was measured there.
struct Champion {
  Tree tree{ActionId{0}};
  std::uint32_t generation = 0;
  double fitness = 0.0;    // scalar
  double agreement = 0.0;  // matches / steps along the walks
  bool operator==(const Champion&) const = default;
};

// One row of a run's statistics.
struct GenerationRecord {
  std::uint32_t generation = 0;  // from 0
  Champion best;                 // highest fitness; ties: fewer nodes, then the lower slot
  double mean_fitness = 0.0;
  double mean_agreement = 0.0;
  double mean_nodes = 0.0;
  std::uint32_t distinct_trees = 0;
  std::uint64_t evaluations = 0;  // individuals evaluated in this generation
  double seconds = 0.0;           // wall time of this generation; the only field that a repetition does not repeat

  std::size_t best_nodes() const { return best.tree.size(); }
  bool operator==(const GenerationRecord&) const = default;
};

// The champions of all generations so far, distinct trees in order of first entry; a tree that led several
// generations keeps its first generation and its highest fitness.
using HallOfFame = std::vector<Champion>;
void enter(const Champion& champion, HallOfFame& hall);
// The highest fitness; ties: fewer nodes, then earlier. REQUIRES: hall is not empty.
const Champion& best_on_record(const HallOfFame& hall);

// Where an evolution stands after a generation was evaluated: all that is needed to go on.
struct Checkpoint {
  std::uint32_t generation = 0;
  std::vector<Tree> population;    // by slot, as evaluated in `generation`
  std::vector<double> fitness;     // by slot
  HallOfFame hall_of_fame;         // `generation` included
  std::vector<Tree> archive = {};  // search front: the trees kept on the front
  bool operator==(const Checkpoint&) const = default;
};

struct EvolveHooks {
  // After each generation was evaluated, before the next is bred: saves the checkpoint, shows progress. An error ends
  // the evolution: interrupted like an interrupted evaluation, any other is returned. May be empty.
  std::function<Result<void>(const GenerationRecord&, const Checkpoint&)> generation_done;
};

struct Evolved {
  Champion best;                       // generation: where it first led
  std::uint64_t final_steps = 0;       // steps on which best.fitness and best.agreement were measured in the end
  std::uint32_t generations_done = 0;  // those before a checkpoint included
  bool interrupted = false;            // best is the highest fitness recorded in its generation; final_steps is 0
  bool pick_fits = true;               // search front: false where best is of the highest fitness, for want of another
  Front front = {};                    // search front: the trees that none other beats in every measure
  bool operator==(const Evolved&) const = default;
};

// Whether evolution of this configuration can go on from there.
Result<void> check_checkpoint(const Checkpoint& start, const GaConfig& ga, const Breeding& breeding);

// Evolves config.ga.generations generations, from the first or from after `start`. Fitness is sampled anew in every
// generation, so a generation's best may owe it to luck: the answer is the champion that does best on one fixed,
// larger sample (config.rollout.final_rollouts roll-outs, kFinalGeneration), or by what is computed
// (config.rollout.final_method); ties: fewer nodes, then earlier.
// A front search (ga.search) shares one sample among all generations (kFrontGeneration) and measures what it kept once
// more on the final one: the front is what none other dominates there, the answer the one that front.pick chooses.
// Errors: whatever the evaluator or a hook reports, except that `interrupted` ends the evolution with what there is,
// once there is one generation; a config or checkpoint that does not fit the chain.
Result<Evolved> evolve(const Chain& chain, const EvolveConfig& config, Evaluator& evaluator,
                       std::optional<Checkpoint> start, const EvolveHooks& hooks);

}  // namespace coppice
