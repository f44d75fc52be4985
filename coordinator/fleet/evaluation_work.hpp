// One evaluate() on its way through the workers: its trees, what of them is sent, and the tallies that follow. Trees
// that mean the same travel once, where finding that out is cheaper than evaluating them twice; it is found out in
// portions, so that the first batches are at work meanwhile. A unit is a tree that is sent.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/fitness/job.hpp"
#include "common/fitness/meaning.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/fleet/request_work.hpp"

namespace coppice {

class EvaluationWork : public RequestWork {
 public:
  // What evaluations of one chain share; it outlives them.
  struct Here {
    const Vocabulary& vocabulary;
    Meanings& meanings;
    Evaluator& reference;
  };

  // The trees outlive it.
  EvaluationWork(std::span<const Tree> trees, const Job& job, bool seek_repeats, const Here& here);

  static WorkClass class_of(const Job& job) { return {WorkKind::evaluate, tally_steps(job)}; }

  RequestTerms terms() const override;
  std::uint32_t look_up_portion() override;
  bool all_seen() const override { return seen_ == trees_.size(); }
  std::vector<std::uint8_t> encode(std::uint32_t first, std::uint32_t count) const override;
  Result<std::vector<UnitOutcome>> decode(std::span<const std::uint8_t> payload, std::uint32_t first,
                                          std::uint32_t count) const override;
  Result<std::vector<UnitOutcome>> compute(std::span<const std::uint32_t> units) override;
  std::string in_words(std::uint32_t unit) const override;

  // Trees that were not sent, because another meant the same.
  std::uint64_t repeated() const { return trees_.size() - sent_.size(); }
  // In the order of the trees. REQUIRES: everything was seen; [units sent].
  std::vector<Tally> tallies(std::vector<UnitOutcome> outcomes) const;

 private:
  std::span<const Tree> trees_;
  Job job_;
  bool seek_repeats_;
  Here here_;
  std::uint64_t steps_;
  std::uint32_t most_per_task_;
  std::uint32_t seen_ = 0;
  std::unordered_map<Meaning, std::uint32_t, MeaningHash> met_;  // which unit
  std::vector<std::uint32_t> sent_;                              // [units] tree
  std::vector<std::uint32_t> sent_as_;                           // [trees seen] unit
};

}  // namespace coppice
