// One evaluate() on its way through the workers: its trees, what of them is sent, and the tallies that came back.
// Trees that mean the same travel once, where finding that out is cheaper than evaluating them twice; it is found out
// in portions, so that the first batches are at work meanwhile. Without DDS; belongs to the dispatching thread.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/fitness/job.hpp"
#include "common/fitness/meaning.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/dispatch/in_flight.hpp"

namespace coppice {

class RemoteRequest {
 public:
  // The trees outlive it.
  RemoteRequest(std::span<const Tree> trees, const Job& job, bool seek_repeats);

  // Looks at the next trees. Returns how many of them are to be sent: the next ones in the order of sending.
  std::uint32_t see_portion(Meanings& meanings);
  std::uint32_t unseen() const { return static_cast<std::uint32_t>(trees_.size()) - seen_; }
  std::uint32_t to_send() const { return static_cast<std::uint32_t>(sent_.size()); }

  const Job& job() const { return job_; }
  // Of every tally that has a result.
  std::uint64_t steps() const { return steps_; }
  // How many trees a task may hold: for the contract's bounds on it and on its answer.
  std::uint32_t most_per_task() const { return most_per_task_; }

  // `first` and `count` are places in the order of sending.
  std::vector<std::uint8_t> task(std::uint32_t first, std::uint32_t count) const;
  // Whether these can be the tallies of what was sent from `first` on.
  bool fits(std::span<const Tally> tallies, std::uint32_t first) const;
  // `by`: who is believed; WorkerId{} when nobody need be.
  void settle(std::uint32_t place, Tally&& tally, WorkerId by) {
    tallies_[place] = std::move(tally);
    settled_by_[place] = by;
  }
  const Tree& sent_tree(std::uint32_t place) const { return trees_[sent_[place]]; }
  std::vector<std::uint32_t> settled_by(WorkerId worker) const;
  // A worker found so many to mean the same as others.
  void add_repeated(std::uint32_t trees) { repeated_ += trees; }
  // No result: too many workers were lost with it. Returns its slot.
  std::uint32_t give_up(std::uint32_t place);

  // Trees that were not evaluated by themselves; for reports.
  std::uint64_t repeated() const { return repeated_ + trees_.size() - sent_.size(); }
  // In the order of the trees. REQUIRES: everything was seen and settled.
  std::vector<Tally> take_tallies();

 private:
  std::span<const Tree> trees_;
  Job job_;
  bool seek_repeats_;
  std::uint64_t steps_;
  std::uint32_t most_per_task_;
  std::uint32_t seen_ = 0;
  std::uint64_t repeated_ = 0;
  std::unordered_map<Meaning, std::uint32_t, MeaningHash> met_;  // where in the order of sending
  std::vector<std::uint32_t> sent_;                              // slots
  std::vector<std::uint32_t> sent_as_;                           // of each slot that was seen: place
  std::vector<Tally> tallies_;                                   // by place
  std::vector<WorkerId> settled_by_;                             // by place
};

}  // namespace coppice
