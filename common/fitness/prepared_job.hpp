// A job made ready for one chain: every random number that its roll-outs can use, drawn once for the whole
// generation (common random numbers, design 3.3), and the score tables of its objectives. Immutable; shared by all
// threads.
//
// Roll-outs are walked side by side in passes of up to kPassLanes lanes. Few roll-outs leave lanes free, and several
// trees share a pass: lane = tree in the pass x roll-outs + roll-out. Many roll-outs take several passes for one tree:
// roll-out = pass x kPassLanes + lane. All arrays of a pass are [steps x lanes], so that a step's draws for
// neighbouring lanes are neighbours in memory.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/fitness/job.hpp"
#include "common/fitness/prepared_chain.hpp"

namespace coppice {

class PreparedJob {
 public:
  static constexpr std::uint32_t kVectorLanes = 8;  // lanes() is a multiple: one 512-bit vector of states
  static constexpr std::uint32_t kPassLanes = 32;   // enough to hide the latency of the loads of a step

  // `previous`, if given, lends its score tables when chain and objectives are the same: generations of
  // one run differ in their draws only. Errors: check_job(), check_solvable(),
  // make_score_table().
  static Result<std::shared_ptr<const PreparedJob>> make(std::shared_ptr<const PreparedChain> chain, const Job& job,
                                                         const std::shared_ptr<const PreparedJob>& previous = nullptr);

  const PreparedChain& chain() const { return *chain_; }
  const Job& job() const { return job_; }
  // One per objective; agreement's is empty.
  const std::vector<ScoreTable>& tables() const { return *tables_; }

  std::uint32_t trees_per_pass() const { return trees_per_pass_; }
  std::uint32_t passes() const { return passes_; }
  // Lanes of a pass in memory; those beyond lanes_used() walk for nothing.
  std::uint32_t lanes() const { return lanes_; }
  // With `trees` trees in the pass.
  std::uint32_t lanes_used(std::uint32_t pass, std::uint32_t trees) const;
  std::uint32_t rollout_of(std::uint32_t pass, std::uint32_t lane) const {
    return pass * kPassLanes + lane % job_.rollouts;
  }
  std::uint32_t tree_of(std::uint32_t lane) const { return passes_ > 1 ? 0 : lane / job_.rollouts; }
  // 32 random bits for each step of a pass. [steps x lanes] REQUIRES (also below): method rollouts.
  const std::uint32_t* draws(std::uint32_t pass) const { return draws_.data() + offset(pass); }
  // Where the roll-outs of a pass start. [lanes]
  const std::uint32_t* starts(std::uint32_t pass) const { return starts_.data() + std::size_t{pass} * lanes_; }
  // Mixed acting policy: 1 where the policy chooses the step. [steps x lanes]; null otherwise.
  const std::uint8_t* policy_acts(std::uint32_t pass) const {
    return policy_acts_.empty() ? nullptr : policy_acts_.data() + offset(pass);
  }

 private:
  PreparedJob() = default;
  void lay_out();
  void draw_all();
  void draw_starts();
  std::size_t offset(std::uint32_t pass) const { return std::size_t{pass} * job_.steps * lanes_; }

  std::shared_ptr<const PreparedChain> chain_;
  Job job_;
  std::uint32_t trees_per_pass_ = 1;
  std::uint32_t passes_ = 1;
  std::uint32_t lanes_ = kVectorLanes;
  std::vector<std::uint32_t> draws_;       // [passes x steps x lanes]
  std::vector<std::uint32_t> starts_;      // [passes x lanes]
  std::vector<std::uint8_t> policy_acts_;  // the same, or empty
  std::shared_ptr<const std::vector<ScoreTable>> tables_;
};

}  // namespace coppice
