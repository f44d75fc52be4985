#include "common/fitness/prepared_job.hpp"

#include <algorithm>
#include <numeric>

namespace coppice {
namespace {

// Beyond this many steps a roll-out hides its latency as well alone, and its draws are not worth copying.
constexpr std::uint32_t kLongWalk = 1U << 14U;
// The acting rows of a pass' trees stay near the core.
constexpr std::size_t kRowsPerPass = std::size_t{1} << 15U;

// For lanes without a roll-out: far from where a row's bins begin and end, so that they decide quickly.
constexpr std::uint32_t kIdleDraw = 0x55555555;

std::uint32_t rounded_up(std::uint32_t lanes) {
  return (lanes + PreparedJob::kVectorLanes - 1) / PreparedJob::kVectorLanes * PreparedJob::kVectorLanes;
}

}  // namespace

Result<std::shared_ptr<const PreparedJob>> PreparedJob::make(std::shared_ptr<const PreparedChain> chain, const Job& job,
                                                             const std::shared_ptr<const PreparedJob>& previous) {
  if (auto ok = check_job(job); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = check_solvable(job, chain->chain().states()); !ok) {
    return tl::unexpected(ok.error());
  }
  std::shared_ptr<PreparedJob> prepared(new PreparedJob());
  if (previous != nullptr && previous->chain_ == chain && previous->job_.objectives == job.objectives) {
    prepared->tables_ = previous->tables_;
  } else {
    auto tables = std::make_shared<std::vector<ScoreTable>>();
    for (const Objective& objective : job.objectives) {
      if (objective.kind == ObjectiveKind::agreement) {  // counted along the walk: no table, which large chains feel
        tables->emplace_back();
        continue;
      }
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
  if (job.method != Method::rollouts) {
    return std::shared_ptr<const PreparedJob>(std::move(prepared));  // nothing is drawn
  }
  prepared->lay_out();
  prepared->draw_all();
  prepared->draw_starts();
  return std::shared_ptr<const PreparedJob>(std::move(prepared));
}

void PreparedJob::lay_out() {
  if (job_.rollouts >= kPassLanes) {
    passes_ = (job_.rollouts + kPassLanes - 1) / kPassLanes;
    lanes_ = kPassLanes;
    return;
  }
  if (chain_->form() == PreparedChain::Form::tables && job_.steps < kLongWalk) {
    const std::size_t near_rows = std::max<std::size_t>(1, kRowsPerPass / chain_->chain().states());
    trees_per_pass_ = static_cast<std::uint32_t>(std::min<std::size_t>(kPassLanes / job_.rollouts, near_rows));
  }
  lanes_ = rounded_up(trees_per_pass_ * job_.rollouts);
}

std::uint32_t PreparedJob::lanes_used(std::uint32_t pass, std::uint32_t trees) const {
  return passes_ > 1 ? std::min(kPassLanes, job_.rollouts - pass * kPassLanes) : trees * job_.rollouts;
}

void PreparedJob::draw_starts() {
  const Chain& chain = chain_->chain();
  starts_.assign(std::size_t{passes_} * lanes_, chain.initial_state());
  if (job_.start == Start::initial && chain.starts().size() == 1) {
    return;
  }
  std::vector<std::uint64_t> shares_to;  // [starts of the chain], of this one and all before it
  for (const StartShare& start : chain.starts()) {
    shares_to.push_back(start.count + (shares_to.empty() ? 0 : shares_to.back()));
  }
  const auto initial = [&](Stream& stream) {
    const auto found = std::upper_bound(shares_to.begin(), shares_to.end(), stream.below(shares_to.back()));
    return chain.starts()[static_cast<std::size_t>(found - shares_to.begin())].state;
  };
  std::vector<std::uint64_t> visits_to;  // [states], of this state and all before it
  if (job_.start == Start::visits) {
    visits_to.resize(chain.states());
    std::partial_sum(chain.parts().visits.begin(), chain.parts().visits.end(), visits_to.begin());
  }
  for (std::uint32_t rollout = 0; rollout < job_.rollouts; ++rollout) {
    Stream stream(job_.seed, Purpose::starting, job_.generation, rollout);
    std::uint64_t state = 0;
    if (job_.start == Start::uniform) {
      state = stream.below(chain.states());
    } else if (job_.start == Start::initial) {
      state = initial(stream);
    } else if (visits_to.back() > 0) {  // a chain without visits has no other start than its own
      const auto found = std::upper_bound(visits_to.begin(), visits_to.end(), stream.below(visits_to.back()));
      state = static_cast<std::uint64_t>(found - visits_to.begin());
    } else {
      state = chain.starts().size() == 1 ? chain.initial_state() : initial(stream);
    }
    const std::size_t first = std::size_t{rollout / kPassLanes} * lanes_ + rollout % kPassLanes;
    for (std::uint32_t tree = 0; tree < trees_per_pass_; ++tree) {
      starts_[first + std::size_t{tree} * job_.rollouts] = static_cast<std::uint32_t>(state);
    }
  }
}

void PreparedJob::draw_all() {
  draws_.assign(offset(passes_), kIdleDraw);
  policy_acts_.resize(job_.acting == Acting::mixed ? draws_.size() : 0);
  std::vector<std::uint32_t> words(job_.steps);
  for (std::uint32_t rollout = 0; rollout < job_.rollouts; ++rollout) {
    const std::uint32_t pass = rollout / kPassLanes;
    const std::size_t first = offset(pass) + rollout % kPassLanes;
    draw_words({job_.seed, Purpose::rollout, job_.generation, rollout, 0}, words);
    for (std::uint32_t step = 0; step < job_.steps; ++step) {
      std::uint8_t policy = 0;
      if (job_.acting == Acting::mixed) {
        policy = draw({job_.seed, Purpose::mixing, job_.generation, rollout, step}) < job_.policy_share ? 1 : 0;
      }
      for (std::uint32_t tree = 0; tree < trees_per_pass_; ++tree) {
        const std::size_t at = first + std::size_t{step} * lanes_ + std::size_t{tree} * job_.rollouts;
        draws_[at] = words[step];
        if (!policy_acts_.empty()) {
          policy_acts_[at] = policy;
        }
      }
    }
  }
}

}  // namespace coppice
