#include "common/fitness/evaluation.hpp"

#include <algorithm>
#include <array>

#include "common/tree/action_table.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kLanes = 8;  // walks side by side

struct WalkInputs {
  const PreparedJob& job;
  const std::uint8_t* tree_acts;  // [states]
  const std::uint8_t* matches;    // [states]
  std::uint32_t* path;            // [rollouts x steps], or null
};

// Walks roll-outs first .. first + Lanes - 1 in lockstep; returns the matches along them.
template <std::uint32_t Lanes, bool kMixed, bool kRecord>
std::uint64_t walk(const WalkInputs& in, std::uint32_t first) {
  const Job& job = in.job.job();
  const AliasRows& rows = in.job.chain().rows();
  const std::uint8_t* policy_acts = in.job.chain().policy().data();
  const std::uint8_t* acts = job.acting == Acting::policy ? policy_acts : in.tree_acts;
  const std::uint64_t* draws = in.job.draws(first).data();
  const std::uint8_t* coins = kMixed ? in.job.policy_acts(first).data() : nullptr;
  std::array<std::uint32_t, Lanes> state;
  state.fill(in.job.chain().chain().initial_state());
  std::uint64_t matched = 0;
  for (std::uint32_t step = 0; step < job.steps; ++step) {
    for (std::uint32_t lane = 0; lane < Lanes; ++lane) {
      const std::size_t at = std::size_t{lane} * job.steps + step;
      const std::uint32_t here = state[lane];
      matched += in.matches[here];
      if constexpr (kRecord) {
        in.path[std::size_t{first} * job.steps + at] = here;
      }
      std::size_t action = acts[here];
      if constexpr (kMixed) {
        action = coins[at] != 0 ? policy_acts[here] : action;
      }
      state[lane] = rows.sample(here, action, draws[at], [&](std::uint32_t attempt) {
        // A stream of its own for each step's further attempts: (roll-out, step, attempt) never meet again.
        return draw({job.seed ^ (std::uint64_t{attempt} << 32U), Purpose::redraw, job.generation, first + lane, step});
      });
    }
  }
  return matched;
}

template <bool kMixed, bool kRecord>
std::uint64_t walk_all(const WalkInputs& in) {
  const std::uint32_t rollouts = in.job.job().rollouts;
  std::uint64_t matched = 0;
  std::uint32_t first = 0;
  for (; first + kLanes <= rollouts; first += kLanes) {
    matched += walk<kLanes, kMixed, kRecord>(in, first);
  }
  switch (rollouts - first) {
    case 7:
      return matched + walk<7, kMixed, kRecord>(in, first);
    case 6:
      return matched + walk<6, kMixed, kRecord>(in, first);
    case 5:
      return matched + walk<5, kMixed, kRecord>(in, first);
    case 4:
      return matched + walk<4, kMixed, kRecord>(in, first);
    case 3:
      return matched + walk<3, kMixed, kRecord>(in, first);
    case 2:
      return matched + walk<2, kMixed, kRecord>(in, first);
    case 1:
      return matched + walk<1, kMixed, kRecord>(in, first);
    default:
      return matched;
  }
}

}  // namespace

Evaluation::Evaluation(std::shared_ptr<const PreparedJob> job) : job_(std::move(job)) {
  const std::size_t states = job_->chain().chain().states();
  actions_.resize(states);
  matches_.resize(states);
  const auto& objectives = job_->job().objectives;
  records_path_ = std::any_of(objectives.begin(), objectives.end(), [](const Objective& objective) {
    return along_walk(objective.kind) && objective.kind != ObjectiveKind::agreement;
  });
  if (records_path_) {
    path_.resize(std::size_t{job_->job().rollouts} * job_->job().steps);
  }
}

Tally Evaluation::evaluate(const Tree& tree) {
  const PreparedChain& chain = job_->chain();
  const auto none = static_cast<std::uint8_t>(chain.chain().actions());
  fill_action_table(tree, chain.columns(), none, actions_);
  for (std::size_t s = 0; s < actions_.size(); ++s) {
    matches_[s] = actions_[s] == chain.policy()[s] ? 1 : 0;
  }
  Tally tally;
  tally.nodes = static_cast<std::uint32_t>(tree.size());
  tally.steps = std::uint64_t{job_->job().rollouts} * job_->job().steps;
  tally.scores.assign(job_->job().objectives.size(), 0);
  score_walks(tally);
  score_states(tally);
  return tally;
}

void Evaluation::score_walks(Tally& tally) {
  const WalkInputs in{*job_, actions_.data(), matches_.data(), path_.data()};
  if (job_->job().acting == Acting::mixed) {
    tally.matches = records_path_ ? walk_all<true, true>(in) : walk_all<true, false>(in);
  } else {
    tally.matches = records_path_ ? walk_all<false, true>(in) : walk_all<false, false>(in);
  }
  const std::size_t stride = job_->chain().chain().actions() + 1;
  for (std::size_t i = 0; i < tally.scores.size(); ++i) {
    const ObjectiveKind kind = job_->job().objectives[i].kind;
    if (kind == ObjectiveKind::agreement) {
      tally.scores[i] = static_cast<std::int64_t>(tally.matches);
    } else if (along_walk(kind)) {
      const std::int64_t* scores = job_->tables()[i].scores.data();
      std::int64_t sum = 0;
      for (const std::uint32_t state : path_) {
        sum += scores[state * stride + actions_[state]];
      }
      tally.scores[i] = sum;
    }
  }
}

void Evaluation::score_states(Tally& tally) const {
  const std::size_t stride = job_->chain().chain().actions() + 1;
  for (std::size_t i = 0; i < tally.scores.size(); ++i) {
    if (along_walk(job_->job().objectives[i].kind)) {
      continue;
    }
    const std::int64_t* scores = job_->tables()[i].scores.data();
    std::int64_t sum = 0;
    for (std::size_t s = 0; s < actions_.size(); ++s) {
      sum += scores[s * stride + actions_[s]];
    }
    tally.scores[i] = sum;
  }
}

}  // namespace coppice
