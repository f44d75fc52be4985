// What the tests of evolution and study evolve on: a small chain whose policy is a known tree, and an evaluator that
// walks it with tick(), one tree and one step at a time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/dispatch/evaluator.hpp"

namespace coppice::testing {

// Features a, b, c (values 0, 1, 3; operator =) and d (values 0 to 2; = and <=); actions move, left, right.
Vocabulary small_vocabulary();

Tree tree_of(std::string_view text);

// All 81 states; the policy is (selector (sequence a=0 left) (sequence b=3 right) move). About one row in ten was
// never tried.
Chain small_chain();

// Walks every tree through the chain. Keeps each call; `stop_at`: the call (from 0) that answers with `error` instead.
class WalkingEvaluator : public Evaluator {
 public:
  struct Call {
    std::vector<Tree> trees;
    Job job;
  };

  explicit WalkingEvaluator(const Chain& chain) : chain_(chain) {}

  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override;
  DispatchStatistics statistics() const override { return {}; }

  std::vector<Call> calls;
  std::size_t stop_at = static_cast<std::size_t>(-1);
  Error error{ErrorKind::interrupted, "stopped"};

 private:
  Tally tally(const Tree& tree, const Job& job) const;

  const Chain& chain_;
};

}  // namespace coppice::testing
