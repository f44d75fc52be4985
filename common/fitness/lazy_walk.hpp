// Roll-outs of one tree that work out nothing but what they meet: the tree is ticked in the states that the walks
// reach, their rows are sampled straight from the chain. For chains too large for tables.
#pragma once

#include <cstdint>
#include <vector>

#include "common/chain/lazy_row.hpp"
#include "common/fitness/prepared_job.hpp"

namespace coppice {

class LazyWalk {
 public:
  // REQUIRES: job->trees_per_pass() == 1.
  explicit LazyWalk(const PreparedJob& job);

  // Walks all roll-outs of `tree`; returns the steps in which its action was the policy's. With `record` path() and
  // path_actions() then hold the states that the walks acted in, and what the tree chose there.
  std::uint64_t walk(const Tree& tree, bool record);

  const std::vector<std::uint32_t>& path() const { return path_; }
  const std::vector<std::uint8_t>& path_actions() const { return path_actions_; }

 private:
  std::uint64_t walk_pass(const Tree& tree, std::uint32_t pass, bool record);

  const PreparedJob& job_;
  LazyRow row_;
  std::vector<std::uint32_t> path_;         // [rollouts x steps], in no particular order
  std::vector<std::uint8_t> path_actions_;  // the same
};

}  // namespace coppice
