// The innermost loop: one pass of roll-outs through the chain, all lanes in lockstep. Chance and choice are tables made
// before, so a step is: the row of the state that the lane is in, the bin that the lane's random bits select, the
// successor. Lanes are independent, which hides the latency of the loads of one behind the others.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "common/fitness/prepared_job.hpp"
#include "common/simd.hpp"

namespace coppice {

// The rows that act in every state under one tree: row(s, acting action of s), its flag set where the tree's action is
// the policy's. Mixed acting has two such tables one after the other, the tree's and the policy's.
using ActingRows = std::vector<PackedRow>;

struct Walk {
  const PreparedJob& job;
  std::uint32_t pass;
  std::uint32_t lanes_used;
  const PackedRow* rows;           // of all trees in the pass
  const std::uint32_t* first_row;  // [lanes], where the acting rows of the lane's tree begin
  std::uint64_t* matches;          // [lanes], out: steps in flagged rows
  std::uint32_t* path;             // [steps x lanes], out: states in which the lanes acted; or null
};

// Writes row(s, actions[s]) for every state s to `out`, flagged where matches(s): actions[s] == policy[s]. `acts` are
// the actions that select the row: `actions` or the policy's. All [states].
struct RowChoice {
  const AliasRows& rows;
  const std::uint8_t* acts;
  const std::uint8_t* actions;
  const std::uint8_t* policy;
  std::size_t states;
};

// REQUIRES (of both): `simd` is none, or best_simd().
void choose_rows(const RowChoice& choice, PackedRow* out, Simd simd);
void walk(const Walk& walk, Simd simd);

// The vector kernels. REQUIRES: best_simd() == Simd::avx512.
void choose_rows_avx512(const RowChoice& choice, PackedRow* out);
void walk_avx512(const Walk& walk);

// Calls body(mixed, path) with what the walk's kernel is specialised for, as constants: whether the policy acts in some
// steps, and whether the path is written.
template <typename Body>
void with_kind_of(const Walk& walk, const Body& body) {
  const auto with_path = [&](auto mixed) {
    walk.path != nullptr ? body(mixed, std::true_type{}) : body(mixed, std::false_type{});
  };
  walk.job.job().acting == Acting::mixed ? with_path(std::true_type{}) : with_path(std::false_type{});
}

// A lane's step whose random bits do not decide alone (alias_bins.hpp).
std::uint32_t step_carefully(const Walk& walk, std::uint32_t lane, std::uint32_t step, PackedRow row);

// Further random bits of a roll-out's step: a stream of its own for each attempt, so that (roll-out, step, attempt)
// never meet again.
inline std::uint64_t more_bits(const Job& job, std::uint32_t rollout, std::uint32_t step, std::uint32_t attempt) {
  return draw({job.seed ^ (std::uint64_t{attempt} << 32U), Purpose::redraw, job.generation, rollout, step});
}

}  // namespace coppice
