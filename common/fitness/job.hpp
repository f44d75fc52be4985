// What is asked of every individual of a generation (Job) and what comes back for each (Tally). Both are plain
// values; a tally is a pure function of (tree, chain, job), wherever it is computed.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/fitness/objective.hpp"
#include "common/named.hpp"

namespace coppice {

// Who chooses the transition in a roll-out (thesis 5-2).
enum class Acting : std::uint8_t { tree = 0, policy = 1, mixed = 2 };

template <>
inline constexpr std::array kNames<Acting> = names("tree", "policy", "mixed");

// Where a roll-out starts: where the chain's episodes do, or in a state drawn as often as it was visited in learning,
// or uniformly: starts that reach what walks from the initial state rarely meet.
enum class Start : std::uint8_t { initial = 0, visits = 1, uniform = 2 };
template <>
inline constexpr std::array kNames<Start> = names("initial", "visits", "uniform");
inline constexpr std::uint8_t kStarts = kNames<Start>.size();

// How what is scored along the walk is found (exact_evaluation.hpp): sampled by roll-outs, or computed as the expected
// value over the same number of steps, discounted, or as the mean over infinitely many steps.
enum class Method : std::uint8_t { rollouts = 0, exact = 1, discounted = 2, long_run = 3 };
template <>
inline constexpr std::array kNames<Method> = names("rollouts", "exact", "discounted", "long_run");
inline constexpr std::uint8_t kMethods = kNames<Method>.size();

// Numbers in [0, 1] travel as shares of 2^64, so that a job has one meaning and one encoding. 1 is the largest share
// there is, 2^-64 short of 1.
std::uint64_t fixed_point_share(double value);
double fixed_point_value(std::uint64_t share);

inline constexpr std::uint32_t kMaxRollouts = 1U << 20U;
inline constexpr std::uint32_t kMaxSteps = 1U << 20U;
inline constexpr std::uint64_t kMaxWalkedSteps = 1ULL << 24U;  // rollouts x steps: their draws are kept in memory
inline constexpr std::size_t kMaxObjectives = 16;

struct Job {
  std::vector<Objective> objectives = {Objective{}};
  std::uint32_t rollouts = 5;  // k of thesis Table III
  std::uint32_t steps = 100;   // t of thesis Table III
  Acting acting = Acting::tree;
  std::uint64_t policy_share = 0;  // mixed: the policy acts in a step with probability policy_share / 2^64
  Method method = Method::rollouts;
  Start start = Start::initial;  // of roll-outs; the other methods start where episodes do
  std::uint64_t gamma = 0;       // discounted: step i weighs (gamma / 2^64)^i; 0 otherwise
  std::uint64_t seed = 0;        // of the run
  std::uint32_t generation = 0;  // with the seed and the roll-out, it names the stream of random numbers
  bool operator==(const Job&) const = default;
};

// Errors name the field, what was found and the limit.
Result<void> check_job(const Job& job);
// Whether a chain of so many states can be solved by the job's method (exact.hpp, kMaxSolvedStates).
Result<void> check_solvable(const Job& job, std::size_t states);

// Tally::steps of whatever this job evaluates: rollouts x steps; of what is computed, the steps that it reads like
// (exact_evaluation.hpp). A tally of 0 steps is one without a result, which only the solving methods may give.
std::uint64_t tally_steps(const Job& job);

struct Tally {
  std::uint32_t nodes = 0;
  std::uint64_t matches = 0;         // steps of the walks in which the tree's action was the policy's
  std::uint64_t steps = 0;           // tally_steps(), or 0: no result
  std::vector<std::int64_t> scores;  // one per objective of the job; divide by ScoreTable::unit for values
  bool operator==(const Tally&) const = default;
};

}  // namespace coppice
