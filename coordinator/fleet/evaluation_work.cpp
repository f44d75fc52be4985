#include "coordinator/fleet/evaluation_work.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>

#include "common/check.hpp"
#include "common/tree/text.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/topics.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kPortion =
    64;  // trees that are looked at before the next go out and messages are taken in: 50 us
// A task's trees; far below the contract's bound, a UDP datagram's size.
constexpr std::size_t kTaskBytes = std::size_t{64} * 1024;

std::uint32_t most_trees(std::span<const Tree> trees, const Job& job) {
  std::size_t largest = 1;
  for (const Tree& tree : trees) {
    largest = std::max(largest, wire::most_encoded_bytes(tree.size()));
  }
  const std::size_t answers =
      (wire::kMaxTaskPayload - sizeof(std::uint32_t)) / wire::encoded_tally_size(job.objectives.size());
  return static_cast<std::uint32_t>(
      std::max<std::size_t>(std::min({kTaskBytes / largest, answers, wire::kMaxTreesPerTask}), 1));
}

}  // namespace

EvaluationWork::EvaluationWork(std::span<const Tree> trees, const Job& job, bool seek_repeats, const Here& here)
    : trees_(trees),
      job_(job),
      seek_repeats_(seek_repeats),
      here_(here),
      steps_(tally_steps(job)),
      most_per_task_(most_trees(trees, job)) {
  COPPICE_CHECK(trees.size() < (std::size_t{1} << 31U));
}

RequestTerms EvaluationWork::terms() const {
  return {
      .work = class_of(job_), .most_per_batch = most_per_task_, .expected = static_cast<std::uint32_t>(trees_.size())};
}

std::uint32_t EvaluationWork::look_up_portion() {
  const std::size_t before = sent_.size();
  const auto all = static_cast<std::uint32_t>(trees_.size());
  if (!seek_repeats_) {
    seen_ = all;
    sent_.resize(seen_);
    std::iota(sent_.begin(), sent_.end(), 0);
    sent_as_ = sent_;
  } else {
    for (const std::uint32_t end = seen_ + std::min(kPortion, all - seen_); seen_ < end; ++seen_) {
      const auto next = static_cast<std::uint32_t>(sent_.size());
      const auto unit = met_.emplace(here_.meanings.of(trees_[seen_]), next).first->second;
      if (unit == next) {
        sent_.push_back(seen_);
      }
      sent_as_.push_back(unit);
    }
  }
  return static_cast<std::uint32_t>(sent_.size() - before);
}

std::vector<std::uint8_t> EvaluationWork::encode(std::uint32_t first, std::uint32_t count) const {
  return wire::encode_task(job_, trees_, std::span(sent_).subspan(first, count));
}

Result<std::vector<UnitOutcome>> EvaluationWork::decode(std::span<const std::uint8_t> payload, std::uint32_t first,
                                                        std::uint32_t count) const {
  auto tallies = wire::decode_tallies(payload, count, job_.objectives.size());
  if (!tallies) {
    return tl::unexpected(tallies.error());
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const Tally& tally = (*tallies)[i];
    const bool steps_fit = tally.steps == steps_ || (job_.method != Method::rollouts && tally.steps == 0);
    if (tally.nodes != trees_[sent_[first + i]].size() || !steps_fit) {
      return bad_input("an answer to another batch");
    }
  }
  return std::vector<UnitOutcome>(std::make_move_iterator(tallies->begin()), std::make_move_iterator(tallies->end()));
}

Result<std::vector<UnitOutcome>> EvaluationWork::compute(std::span<const std::uint32_t> units) {
  std::vector<Tree> trees;
  trees.reserve(units.size());
  for (const std::uint32_t unit : units) {
    trees.push_back(trees_[sent_[unit]]);
  }
  auto tallies = here_.reference.evaluate(trees, job_);
  if (!tallies) {
    return tl::unexpected(tallies.error());
  }
  return std::vector<UnitOutcome>(std::make_move_iterator(tallies->begin()), std::make_move_iterator(tallies->end()));
}

std::string EvaluationWork::in_words(std::uint32_t unit) const {
  const std::string tree = to_text(trees_[sent_[unit]], here_.vocabulary);
  return fmt::format(
      "the tree {} (seed {}, generation {}); to see it again: echo '{}' | coppice evaluate STUDY --serial", tree,
      job_.seed, job_.generation, tree);
}

std::vector<Tally> EvaluationWork::tallies(std::vector<UnitOutcome> outcomes) const {
  COPPICE_CHECK(all_seen() && outcomes.size() == sent_.size());
  std::vector<Tally> tallies;
  tallies.reserve(trees_.size());
  for (std::size_t slot = 0; slot < trees_.size(); ++slot) {
    Tally& outcome = std::get<Tally>(outcomes[sent_as_[slot]]);
    // Whose meaning is met again gives a copy.
    tallies.push_back(sent_.size() == trees_.size() ? std::move(outcome) : outcome);
    tallies.back().nodes = static_cast<std::uint32_t>(trees_[slot].size());
  }
  return tallies;
}

}  // namespace coppice
