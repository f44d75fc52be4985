// Evolution: breeds trees that do what the chain's policy does (thesis Algorithm 1 and VI-E.3). The result is a pure
// function of (chain, config): chance in generation g depends on (seed, g) alone, so an evolution that is resumed from
// a checkpoint, or evaluated elsewhere, ends with the very same trees and numbers. Runs on the calling thread;
// everything costly happens behind the Evaluator.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/evolution/breeding.hpp"
#include "common/evolution/champion.hpp"
#include "common/evolution/config.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/evolution/pick.hpp"

namespace coppice {

// Where an evolution stands after a generation was evaluated: all that is needed to go on.
struct Checkpoint {
  std::uint32_t generation = 0;
  std::vector<Tree> population;        // by slot, as evaluated in `generation`
  std::vector<double> fitness;         // by slot; the slots of one deme behind those of another
  HallOfFame hall_of_fame;             // `generation` included
  std::vector<Tree> archive = {};      // search front: the trees kept on the front, deme by deme
  std::vector<std::size_t> kept = {};  // several demes: how many trees of the archive each has; else empty
  bool operator==(const Checkpoint&) const = default;
};

// What is called on the thread of evolve(), before what comes next is bred. Any of it may be empty.
struct EvolveHooks {
  // With the generations that were done since the last call, in their order, and where the run stands after the last of
  // them: saves them, shows progress. Of several demes, after each epoch that all of them have ended. An error ends the
  // evolution: interrupted like an interrupted evaluation, any other is returned.
  std::function<Result<void>(std::span<const GenerationRecord>, const Checkpoint&)> generations_done = {};
  // One deme: whether a generation that has just been done, and all before it, are to be told of now; empty: every one
  // at once. They are in any case once the run ends, is interrupted, or its evaluator fails.
  std::function<bool()> due = {};
  // Several demes: of the same epoch, and before that, each one's own records. [demes][generations] May be empty.
  std::function<void(std::span<const std::vector<GenerationRecord>>)> demes_done = {};
  // One deme, too, as an epoch that lasts the whole run: wherever that runs, it is sent nothing on the way. For who has
  // many runs and needs no checkpoints.
  bool whole = false;
  bool count_meanings = false;  // GenerationRecord::meanings
};

// Paces what is saved, so that saving takes no more than a fiftieth of the time: at the thesis' size a generation costs
// less than its checkpoint. What a run may lose with its process is what it did since: at most a second and a
// generation.
class SavePace {
 public:
  // Whether to save now.
  bool due() const;
  // Saves, and remembers what that took.
  Result<void> save(const std::function<Result<void>()>& saving);

 private:
  std::chrono::steady_clock::time_point ended_{};
  std::chrono::steady_clock::duration took_{0};
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
Result<void> check_checkpoint(const Checkpoint& start, const EvolveConfig& config, const Breeding& breeding);

// Evolves config.ga.generations generations, from the first or from after `start`. Fitness is sampled anew in every
// generation, so a generation's best may owe it to luck: the answer is the champion that does best on one fixed,
// larger sample (config.rollout.final_rollouts roll-outs, kFinalGeneration), or by what is computed
// (config.rollout.final_method); ties: fewer nodes, then earlier.
// With several demes (ga.demes) epochs run wherever the evaluator has them run; the result is the same anywhere.
// A front search (ga.search) shares one sample among all generations (kFrontGeneration) and measures what it kept once
// more on the final one: the front is what none other dominates there, the answer the one that front.pick chooses.
// Errors: whatever the evaluator or a hook reports, except that `interrupted` ends the evolution with what there is,
// once there is one generation; a config or checkpoint that does not fit the chain.
Result<Evolved> evolve(const Chain& chain, const EvolveConfig& config, Evaluator& evaluator,
                       std::optional<Checkpoint> start, const EvolveHooks& hooks);

}  // namespace coppice
