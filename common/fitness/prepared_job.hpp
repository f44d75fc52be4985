// A job made ready for one chain: every random number that its roll-outs can use, drawn once for the whole
// generation (common random numbers, design 3.3), and the score tables of its objectives. Immutable; shared by all
// threads.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/fitness/job.hpp"
#include "common/fitness/prepared_chain.hpp"

namespace coppice {

class PreparedJob {
 public:
  // `previous`, if given, lends its score tables when chain and objectives are the same: generations of
  // one run differ in their draws only. Errors: check_job(), make_score_table().
  static Result<std::shared_ptr<const PreparedJob>> make(std::shared_ptr<const PreparedChain> chain, const Job& job,
                                                         const std::shared_ptr<const PreparedJob>& previous = nullptr);

  const PreparedChain& chain() const { return *chain_; }
  const Job& job() const { return job_; }
  // Random bits of a roll-out's steps. [steps]
  std::span<const std::uint64_t> draws(std::uint32_t rollout) const {
    return std::span<const std::uint64_t>(draws_).subspan(std::size_t{rollout} * job_.steps, job_.steps);
  }
  // Mixed acting policy: 1 where the policy chooses the step. [steps]; empty otherwise.
  std::span<const std::uint8_t> policy_acts(std::uint32_t rollout) const {
    return policy_acts_.empty()
               ? std::span<const std::uint8_t>()
               : std::span<const std::uint8_t>(policy_acts_).subspan(std::size_t{rollout} * job_.steps, job_.steps);
  }
  const std::vector<ScoreTable>& tables() const { return *tables_; }

 private:
  PreparedJob() = default;

  std::shared_ptr<const PreparedChain> chain_;
  Job job_;
  std::vector<std::uint64_t> draws_;       // [rollouts x steps]
  std::vector<std::uint8_t> policy_acts_;  // [rollouts x steps] or empty
  std::shared_ptr<const std::vector<ScoreTable>> tables_;
};

}  // namespace coppice
