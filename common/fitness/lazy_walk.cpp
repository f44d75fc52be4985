#include "common/fitness/lazy_walk.hpp"

#include <algorithm>
#include <array>

#include "common/check.hpp"
#include "common/fitness/walk.hpp"
#include "common/tree/tick.hpp"

namespace coppice {
namespace {

// The next step of every lane starts with these loads; asked for now, they arrive while the other lanes step.
void prefetch_state(const Chain& chain, std::uint32_t state) {
  const ChainParts& parts = chain.parts();
  __builtin_prefetch(parts.features.data() + state * parts.vocabulary.features.size());
  __builtin_prefetch(parts.row_begin.data() + state * chain.actions());
  __builtin_prefetch(parts.policy.data() + state);
}

}  // namespace

LazyWalk::LazyWalk(const PreparedJob& job) : job_(job) { COPPICE_CHECK(job.trees_per_pass() == 1); }

std::uint64_t LazyWalk::walk(const Tree& tree, bool record) {
  path_.clear();
  path_actions_.clear();
  std::uint64_t matches = 0;
  for (std::uint32_t pass = 0; pass < job_.passes(); ++pass) {
    matches += walk_pass(tree, pass, record);
  }
  return matches;
}

std::uint64_t LazyWalk::walk_pass(const Tree& tree, std::uint32_t pass, bool record) {
  const Job& job = job_.job();
  const Chain& chain = job_.chain().chain();
  const std::uint32_t lanes = job_.lanes_used(pass, 1);
  const std::uint32_t* draws = job_.draws(pass);
  const std::uint8_t* policy_acts = job_.policy_acts(pass);
  std::array<std::uint32_t, PreparedJob::kPassLanes> state;
  std::copy_n(job_.starts(pass), job_.lanes(), state.begin());
  const bool has_terminals = !chain.parts().terminals.empty();
  std::uint64_t matches = 0;
  for (std::uint32_t step = 0; step < job.steps; ++step) {
    for (std::uint32_t lane = 0; lane < lanes; ++lane) {
      const std::size_t at = std::size_t{step} * job_.lanes() + lane;
      const std::uint32_t here = state[lane];
      const ActionId action = tick(tree, chain.features_of(here));
      const ActionId policy = chain.policy(here);
      const std::size_t chosen = action == kNoAction ? chain.actions() : index_of(action);
      matches += action == policy || (has_terminals && chain.is_terminal(here)) ? 1 : 0;
      if (record) {
        path_.push_back(here);
        path_actions_.push_back(static_cast<std::uint8_t>(chosen));
      }
      const bool policy_chooses = job.acting == Acting::policy || (policy_acts != nullptr && policy_acts[at] != 0);
      const std::size_t acts = policy_chooses ? index_of(policy) : chosen;
      state[lane] = row_.sample(chain, here, acts, draws[at], [&](std::uint32_t attempt) {
        return more_bits(job, job_.rollout_of(pass, lane), step, attempt);
      });
      prefetch_state(chain, state[lane]);
    }
  }
  return matches;
}

}  // namespace coppice
