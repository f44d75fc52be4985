// The pure function that everything else moves to where the cores are:
//
//   tally = evaluate(tree, prepared job)         (tree, chain, objectives, seed -> integers)
//
// One tree costs its action table (bit-parallel, all states at once) and its roll-outs, several of which are
// walked side by side so that the loads of one hide behind the others.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/fitness/prepared_job.hpp"

namespace coppice {

// Scratch memory of one thread; reused from tree to tree so that evaluation does not allocate.
class Evaluation {
 public:
  explicit Evaluation(std::shared_ptr<const PreparedJob> job);

  // REQUIRES: check_tree(tree, vocabulary of the chain).
  Tally evaluate(const Tree& tree);

 private:
  void score_walks(Tally& tally);
  void score_states(Tally& tally) const;

  std::shared_ptr<const PreparedJob> job_;
  bool records_path_ = false;          // some objective other than agreement is scored along the walk
  std::vector<std::uint8_t> actions_;  // [states], the tree's action table; `actions` of the chain means none
  std::vector<std::uint8_t> matches_;  // [states], 1 where tree and policy agree
  std::vector<std::uint32_t> path_;    // [rollouts x steps], states in which the walks acted; if recorded
};

}  // namespace coppice
