// What is asked of every individual of a generation (Job) and what comes back for each (Tally). Both are plain
// values; a tally is a pure function of (tree, chain, job), wherever it is computed.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/fitness/objective.hpp"

namespace coppice {

// Who chooses the transition in a roll-out (thesis 5-2).
enum class Acting : std::uint8_t { tree = 0, policy = 1, mixed = 2 };

std::string_view name_of(Acting acting);
Result<Acting> acting_named(std::string_view name);

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
  std::uint64_t seed = 0;          // of the run
  std::uint32_t generation = 0;    // with the seed and the roll-out, it names the stream of random numbers
  bool operator==(const Job&) const = default;
};

// Errors name the field, what was found and the limit.
Result<void> check_job(const Job& job);

struct Tally {
  std::uint32_t nodes = 0;
  std::uint64_t matches = 0;         // steps of the walks in which the tree's action was the policy's
  std::uint64_t steps = 0;           // rollouts x steps
  std::vector<std::int64_t> scores;  // one per objective of the job; divide by ScoreTable::unit for values
  bool operator==(const Tally&) const = default;
};

}  // namespace coppice
