#include "common/fitness/evaluation.hpp"

#include <algorithm>
#include <array>

#include "common/tree/action_table.hpp"

namespace coppice {
namespace {

// Tallies kept for trees that mean the same; far more than a generation has individuals.
constexpr std::size_t kMaxKnown = std::size_t{1} << 16U;

}  // namespace

Evaluation::Evaluation(std::shared_ptr<const PreparedJob> job, Simd simd) : simd_(simd) { begin(std::move(job)); }

void Evaluation::begin(std::shared_ptr<const PreparedJob> job) {
  job_ = std::move(job);
  known_.clear();
  tallies_.clear();
  lazy_.reset();
  exact_.reset();
  scores_path_ = false;
  scores_states_ = false;
  for (const Objective& objective : job_->job().objectives) {
    scores_path_ = scores_path_ || (along_walk(objective.kind) && objective.kind != ObjectiveKind::agreement);
    scores_states_ = scores_states_ || !along_walk(objective.kind);
  }
  const std::size_t states = job_->chain().chain().states();
  if (job_->job().method != Method::rollouts) {
    exact_.emplace(job_);
    actions_.resize(states);
    return;
  }
  if (job_->chain().form() == PreparedChain::Form::lazy) {
    lazy_.emplace(*job_);
    actions_.resize(scores_states_ ? states : 0);
    return;
  }
  const std::size_t trees = job_->trees_per_pass();
  const std::size_t tables = job_->job().acting == Acting::mixed ? 2 : 1;
  actions_.resize(trees * states);
  rows_.resize(trees * tables * states);
  matches_.resize(job_->lanes());
  path_.resize(scores_path_ ? std::size_t{job_->job().steps} * job_->lanes() : 0);
  first_row_.assign(job_->lanes(), 0);
}

// Lanes beyond those in use fill the last vector and walk for nothing: with the rows of the pass's first tree, for
// those of any other tree are left over from an earlier pass, perhaps through another chain, whose states are not this
// one's.
void Evaluation::point_lanes(std::uint32_t used) {
  const std::size_t tables = job_->job().acting == Acting::mixed ? 2 : 1;
  const std::size_t rows_per_tree = tables * job_->chain().chain().states();
  for (std::uint32_t lane = 0; lane < job_->lanes(); ++lane) {
    first_row_[lane] = lane < used ? static_cast<std::uint32_t>(job_->tree_of(lane) * rows_per_tree) : 0;
  }
}

std::vector<Tally> Evaluation::evaluate(std::span<const Tree> trees) {
  if (known_.size() > kMaxKnown) {
    known_.clear();
    tallies_.clear();
  }
  std::vector<std::size_t> indices;
  indices.reserve(trees.size());
  for (const Tree& tree : trees) {
    indices.push_back(known_index_of(tree));
    if (waiting_.size() == job_->trees_per_pass()) {
      walk_waiting();
    }
  }
  if (!waiting_.empty()) {
    walk_waiting();
  }
  std::vector<Tally> tallies;
  tallies.reserve(trees.size());
  for (std::size_t i = 0; i < trees.size(); ++i) {
    tallies.push_back(tallies_[indices[i]]);
    tallies.back().nodes = static_cast<std::uint32_t>(trees[i].size());
  }
  return tallies;
}

// Where the tally of the tree's meaning is, or will be once the waiting trees have walked.
std::size_t Evaluation::known_index_of(const Tree& tree) {
  const auto none = static_cast<std::uint8_t>(job_->chain().chain().actions());
  const std::span<std::uint8_t> actions = actions_of(waiting_.size());
  if (!lazy_) {
    fill_action_table(tree, job_->chain().columns(), none, actions, simd_);
  }
  const Meaning meaning = lazy_ ? meaning_of(tree) : meaning_of(actions);
  const auto [found, added] = known_.emplace(meaning, tallies_.size());
  if (!added) {
    ++repeated_;
    return found->second;
  }
  Tally& tally = tallies_.emplace_back();
  tally.steps = tally_steps(job_->job());
  tally.scores.assign(job_->job().objectives.size(), 0);
  if (exact_) {
    exact_->score_walks(actions, tally);
  } else if (lazy_) {
    walk_lazily(tree, tally);
    if (scores_states_) {
      fill_action_table(tree, job_->chain().columns(), none, actions, simd_);
    }
  } else {
    waiting_.push_back(found->second);
  }
  score_states(actions, tally);
  return found->second;
}

std::span<std::uint8_t> Evaluation::actions_of(std::size_t waiting) {
  const std::size_t states = lazy_ ? actions_.size() : job_->chain().chain().states();
  return std::span<std::uint8_t>(actions_).subspan(waiting * states, states);
}

void Evaluation::walk_waiting() {
  const PreparedChain& chain = job_->chain();
  const std::size_t states = chain.chain().states();
  const Acting acting = job_->job().acting;
  PackedRow* out = rows_.data();
  for (std::size_t tree = 0; tree < waiting_.size(); ++tree) {
    const std::uint8_t* actions = actions_of(tree).data();
    const std::uint8_t* policy = chain.policy().data();
    if (acting != Acting::policy) {
      choose_rows({chain.rows(), actions, actions, policy, states}, out, simd_);
      flag_terminals(out);
      out += states;
    }
    if (acting != Acting::tree) {
      choose_rows({chain.rows(), policy, actions, policy, states}, out, simd_);
      flag_terminals(out);
      out += states;
    }
  }
  for (std::uint32_t pass = 0; pass < job_->passes(); ++pass) {
    const std::uint32_t used = job_->lanes_used(pass, static_cast<std::uint32_t>(waiting_.size()));
    point_lanes(used);
    walk({*job_, pass, used, rows_.data(), first_row_.data(), matches_.data(), scores_path_ ? path_.data() : nullptr},
         simd_);
    for (std::uint32_t lane = 0; lane < used; ++lane) {
      tallies_[waiting_[job_->tree_of(lane)]].matches += matches_[lane];
    }
    if (scores_path_) {
      score_path(pass);
    }
  }
  for (std::size_t i = 0; i < job_->job().objectives.size(); ++i) {
    if (job_->job().objectives[i].kind == ObjectiveKind::agreement) {
      for (const std::size_t index : waiting_) {
        tallies_[index].scores[i] = static_cast<std::int64_t>(tallies_[index].matches);
      }
    }
  }
  waiting_.clear();
}

// Nothing is decided where an episode has ended: whatever was chosen there is the policy's choice, too, and all rows of
// the state are alike.
void Evaluation::flag_terminals(PackedRow* rows) const {
  const PreparedChain& chain = job_->chain();
  for (const std::uint32_t state : chain.chain().parts().terminals) {
    rows[state] = chain.rows().row(state, 0) | kRowFlag;
  }
}

namespace {

// One tree's path through a pass: [steps] lines of `stride` states, of which the first `lanes` are its own.
struct Path {
  const std::uint32_t* states;
  std::uint32_t steps;
  std::uint32_t stride;
  std::uint32_t lanes;
};

// The sums of kTables score tables [states x row] over a path. What a step looks up is found once for all of them.
template <std::size_t kTables>
void add_scores(const Path& path, const std::uint8_t* actions, std::size_t row, const std::int64_t* const* tables,
                std::int64_t* sums) {
  std::array<const std::int64_t*, kTables> table;
  std::copy_n(tables, kTables, table.begin());
  std::array<std::int64_t, kTables> sum{};
  const std::uint32_t* line = path.states;
  for (std::uint32_t step = 0; step < path.steps; ++step, line += path.stride) {
    for (std::uint32_t lane = 0; lane < path.lanes; ++lane) {
      const std::size_t at = line[lane] * row + actions[line[lane]];
      for (std::size_t t = 0; t < kTables; ++t) {
        sum[t] += table[t][at];
      }
    }
  }
  std::copy_n(sum.begin(), kTables, sums);
}

}  // namespace

void Evaluation::score_path(std::uint32_t pass) {
  const std::size_t row = job_->chain().chain().actions() + 1;
  const std::uint32_t lanes_per_tree = job_->lanes_used(pass, 1);
  std::array<const std::int64_t*, kMaxObjectives> tables;
  std::array<std::size_t, kMaxObjectives> objectives;
  std::size_t count = 0;
  for (std::size_t i = 0; i < job_->job().objectives.size(); ++i) {
    const ObjectiveKind kind = job_->job().objectives[i].kind;
    if (along_walk(kind) && kind != ObjectiveKind::agreement) {
      tables[count] = job_->tables()[i].scores.data();
      objectives[count++] = i;
    }
  }
  using Add = void (*)(const Path&, const std::uint8_t*, std::size_t, const std::int64_t* const*, std::int64_t*);
  constexpr std::array<Add, 4> kAdd = {add_scores<1>, add_scores<2>, add_scores<3>, add_scores<4>};
  for (std::size_t tree = 0; tree < waiting_.size(); ++tree) {
    const Path path{path_.data() + tree * lanes_per_tree, job_->job().steps, job_->lanes(), lanes_per_tree};
    for (std::size_t first = 0; first < count; first += kAdd.size()) {
      const std::size_t some = std::min(kAdd.size(), count - first);
      std::array<std::int64_t, kAdd.size()> sums;
      kAdd[some - 1](path, actions_of(tree).data(), row, tables.data() + first, sums.data());
      for (std::size_t i = 0; i < some; ++i) {
        tallies_[waiting_[tree]].scores[objectives[first + i]] += sums[i];
      }
    }
  }
}

void Evaluation::walk_lazily(const Tree& tree, Tally& tally) {
  tally.matches = lazy_->walk(tree, scores_path_);
  const std::size_t stride = job_->chain().chain().actions() + 1;
  for (std::size_t i = 0; i < tally.scores.size(); ++i) {
    const ObjectiveKind kind = job_->job().objectives[i].kind;
    if (kind == ObjectiveKind::agreement) {
      tally.scores[i] = static_cast<std::int64_t>(tally.matches);
    } else if (along_walk(kind)) {
      const std::int64_t* scores = job_->tables()[i].scores.data();
      for (std::size_t at = 0; at < lazy_->path().size(); ++at) {
        tally.scores[i] += scores[lazy_->path()[at] * stride + lazy_->path_actions()[at]];
      }
    }
  }
}

void Evaluation::score_states(std::span<const std::uint8_t> actions, Tally& tally) const {
  const std::size_t stride = job_->chain().chain().actions() + 1;
  for (std::size_t i = 0; i < tally.scores.size(); ++i) {
    if (along_walk(job_->job().objectives[i].kind)) {
      continue;
    }
    const std::int64_t* scores = job_->tables()[i].scores.data();
    std::int64_t sum = 0;
    for (std::size_t s = 0; s < actions.size(); ++s) {
      sum += scores[s * stride + actions[s]];
    }
    tally.scores[i] = sum;
  }
}

}  // namespace coppice
