#include "common/fitness/prepared_job.hpp"

namespace coppice {

Result<std::shared_ptr<const PreparedJob>> PreparedJob::make(std::shared_ptr<const PreparedChain> chain, const Job& job,
                                                             const std::shared_ptr<const PreparedJob>& previous) {
  if (auto ok = check_job(job); !ok) {
    return tl::unexpected(ok.error());
  }
  std::shared_ptr<PreparedJob> prepared(new PreparedJob());
  if (previous != nullptr && previous->chain_ == chain && previous->job_.objectives == job.objectives) {
    prepared->tables_ = previous->tables_;
  } else {
    auto tables = std::make_shared<std::vector<ScoreTable>>();
    for (const Objective& objective : job.objectives) {
      auto table = make_score_table(chain->chain(), objective);
      if (!table) {
        return tl::unexpected(table.error());
      }
      tables->push_back(std::move(*table));
    }
    prepared->tables_ = std::move(tables);
  }
  prepared->chain_ = std::move(chain);
  prepared->job_ = job;
  prepared->draws_.reserve(std::size_t{job.rollouts} * job.steps);
  for (std::uint32_t rollout = 0; rollout < job.rollouts; ++rollout) {
    for (std::uint32_t step = 0; step < job.steps; ++step) {
      prepared->draws_.push_back(draw({job.seed, Purpose::rollout, job.generation, rollout, step}));
      if (job.acting == Acting::mixed) {
        const std::uint64_t coin = draw({job.seed, Purpose::mixing, job.generation, rollout, step});
        prepared->policy_acts_.push_back(coin < job.policy_share ? 1 : 0);
      }
    }
  }
  return std::shared_ptr<const PreparedJob>(std::move(prepared));
}

}  // namespace coppice
