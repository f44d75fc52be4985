// One Evaluation that goes on from chain to chain, as a worker's does, gives what a new one would: for every pair of
// chain sizes and with vectors as without. The vector code gathers from rows, and a row left over from another chain
// reaches far outside of this one's bins, which AddressSanitizer does not see but the processor does.
#include <gtest/gtest.h>
#include <numeric>

#include "common/fitness/evaluation.hpp"
#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

// Every state follows every other, so that a row of the largest chain begins megabytes after the bins of a small one.
std::shared_ptr<const PreparedChain> wide_chain(std::uint32_t states) {
  ChainParts parts = oracles::random_chain({.states = states, .actions = 3, .seed = states}).parts();
  parts.row_begin = {0};
  parts.successor.clear();
  parts.count.clear();
  for (std::uint32_t row = 0; row < states * 3; ++row) {
    for (std::uint32_t next = 0; next < states; ++next) {
      parts.successor.push_back(next);
      parts.count.push_back(1 + (row + next) % 5);
    }
    parts.row_begin.push_back(parts.successor.size());
  }
  return PreparedChain::make(std::make_shared<const Chain>(*Chain::make(std::move(parts))));
}

TEST(ReusedEvaluation, GivesWhatANewOneGivesFromEveryChainSizeToEveryOther) {
  std::vector<std::shared_ptr<const PreparedChain>> chains;
  for (const std::uint32_t states : {1U, 2U, 9U, 100U, 729U}) {
    chains.push_back(wide_chain(states));
  }
  std::vector<Simd> ways = {Simd::none};
  if (best_simd() != Simd::none) {
    ways.push_back(best_simd());
  }
  for (const Acting acting : {Acting::tree, Acting::mixed}) {
    for (const Simd simd : ways) {
      for (const auto& before : chains) {
        for (const auto& after : chains) {
          Job job;
          job.objectives = {{ObjectiveKind::agreement, {}}, {ObjectiveKind::expected_return, {}}};
          job.acting = acting;
          job.policy_share = std::uint64_t{1} << 62U;
          const auto trees = oracles::random_trees(after->chain().vocabulary(), 24, 5);
          Evaluation reused(*PreparedJob::make(before, job), simd);
          reused.evaluate(trees);
          const auto prepared = *PreparedJob::make(after, job);
          reused.begin(prepared);
          Evaluation fresh(prepared, simd);
          for (std::size_t count : {1U, 2U, 24U}) {
            ASSERT_EQ(reused.evaluate(std::span(trees).first(count)), fresh.evaluate(std::span(trees).first(count)))
                << before->chain().states() << " states, then " << after->chain().states();
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace coppice
