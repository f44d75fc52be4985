// Packs jobs, trees and tallies into the payloads of the contract (idl/coppice.idl), and is the only decoder of
// foreign bytes: strict, linear in the input, allocating no more than the input justifies, never throwing. Whatever a
// decode function returns is as good as if it had been made here: trees passed check_tree(), jobs check_job().
//
// Task payload, little-endian:
//   job:   u64 seed, u32 generation, u32 rollouts, u32 steps, u8 acting, u64 policy share,
//          u8 method, u64 gamma, u8 start,
//          u8 objectives, each {u8 kind, f64 threshold, u8 rules, each {i32 right, i32 wrong, u8 conditions, each
//          {node}}}
//   trees: u32 count, each {u16 nodes, each {node} in prefix order}
//   node:  u8 kind + 4 x op, then composite: u16 extent; condition: u8 feature, u8 value; action: u8 action
// Answer payload: u32 count, each {u32 nodes, u64 matches, u64 steps, i64 score for each objective of the job}
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/bytes.hpp"
#include "common/error.hpp"
#include "common/fitness/job.hpp"
#include "common/tree/tree.hpp"
#include "common/tree/tree_checker.hpp"

namespace coppice::wire {

inline constexpr std::size_t kMaxTreesPerTask = 65536;

// Bytes that encode_task() spends at most on a tree of so many nodes.
constexpr std::size_t most_encoded_bytes(std::size_t nodes) { return 2 + 3 * nodes; }

// REQUIRES: trees.size() <= kMaxTreesPerTask.
std::vector<std::uint8_t> encode_task(const Job& job, std::span<const Tree> trees);
// Of the trees at these places only. REQUIRES: every place < trees.size(); places.size() <= kMaxTreesPerTask.
std::vector<std::uint8_t> encode_task(const Job& job, std::span<const Tree> trees,
                                      std::span<const std::uint32_t> places);

struct DecodedTask {
  Job job;
  std::vector<Tree> trees;
};

// For tasks that come one after another on one chain. Belongs to one thread.
class TaskDecoder {
 public:
  // The vocabulary must outlive it.
  explicit TaskDecoder(const Vocabulary& vocabulary) : checker_(vocabulary) {}

  Result<DecodedTask> decode(std::span<const std::uint8_t> payload);
  // Takes back a task that is done with: the next one uses its memory.
  void recycle(DecodedTask&& task);

 private:
  Result<Tree> read_tree(std::span<const std::uint8_t>& bytes);

  TreeChecker checker_;
  std::vector<Tree> trees_;  // without elements
  std::vector<std::vector<Node>> nodes_;
};

// Bytes that encode_tallies() spends on one tally.
std::size_t encoded_tally_size(std::size_t objectives);

std::vector<std::uint8_t> encode_tallies(std::span<const Tally> tallies);
// Errors also when the answer does not hold `trees` tallies of `objectives` scores each.
Result<std::vector<Tally>> decode_tallies(std::span<const std::uint8_t> payload, std::size_t trees,
                                          std::size_t objectives);

}  // namespace coppice::wire
