// The pure function that everything else moves to where the cores are:
//
//   tally = evaluate(tree, prepared job)         (tree, chain, objectives, seed -> integers)
//
// One tree costs its action table (bit-parallel, all states at once), the rows that act under it, and its roll-outs,
// walked side by side with those of other trees (walk.hpp). Trees that mean the same are walked once. On a chain
// without tables a tree costs the states that its walks reach (lazy_walk.hpp). A job may ask for expected values
// instead of roll-outs (exact_evaluation.hpp).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/fitness/exact_evaluation.hpp"
#include "common/fitness/lazy_walk.hpp"
#include "common/fitness/meaning.hpp"
#include "common/fitness/prepared_job.hpp"
#include "common/fitness/walk.hpp"
#include "common/simd.hpp"

namespace coppice {

// One thread's scratch memory and what it has evaluated for its job.
class Evaluation {
 public:
  // REQUIRES: `simd` is none, or best_simd().
  explicit Evaluation(std::shared_ptr<const PreparedJob> job, Simd simd = best_simd());

  // Goes on with another job, as if made anew but for the memory that it holds: a generation allocates nothing.
  void begin(std::shared_ptr<const PreparedJob> job);

  // One tally per tree, in their order. REQUIRES: check_tree(tree, vocabulary of the chain) for each.
  std::vector<Tally> evaluate(std::span<const Tree> trees);
  Tally evaluate(const Tree& tree) { return evaluate({&tree, 1}).front(); }

  // Trees that share their walks; a good number to give to evaluate() is a small multiple.
  std::uint32_t trees_per_pass() const { return job_->trees_per_pass(); }
  // Trees so far that meant what one before them had meant.
  std::uint64_t repeated() const { return repeated_; }

 private:
  std::size_t known_index_of(const Tree& tree);
  std::span<std::uint8_t> actions_of(std::size_t waiting);
  void walk_waiting();
  void point_lanes(std::uint32_t used);
  void walk_lazily(const Tree& tree, Tally& tally);
  void flag_terminals(PackedRow* rows) const;
  void score_path(std::uint32_t pass);
  void score_states(std::span<const std::uint8_t> actions, Tally& tally) const;

  std::shared_ptr<const PreparedJob> job_;
  Simd simd_;
  bool scores_path_ = false;    // some objective other than agreement is scored along the walk
  bool scores_states_ = false;  // some objective is scored over all states
  // What there is instead of whole tables and passes; one of them at most.
  std::optional<LazyWalk> lazy_;
  std::optional<ExactEvaluation> exact_;

  std::unordered_map<Meaning, std::size_t, MeaningHash> known_;  // index into tallies_
  std::vector<Tally> tallies_;
  std::uint64_t repeated_ = 0;

  // The trees whose walks are still to be made, at most trees_per_pass().
  std::vector<std::size_t> waiting_;      // indices into tallies_
  std::vector<std::uint8_t> actions_;     // [trees per pass x states], action tables; the number of actions means none
  ActingRows rows_;                       // [trees per pass x acting tables x states]
  std::vector<std::uint32_t> first_row_;  // [lanes]
  std::vector<std::uint64_t> matches_;    // [lanes]
  std::vector<std::uint32_t> path_;       // [steps x lanes], if scored
};

}  // namespace coppice
