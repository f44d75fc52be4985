// Trust in workers' answers: a share of what they computed is computed by the coordinator again, by the kernel that is
// the reference for everybody. A worker that answered wrongly, even once, is found out; what else it said can then be
// computed again. We differ: a second worker's opinion would spare the coordinator's core, but two workers of one
// broken build agree.
//
// A worker that is new gives a sample of each of its first answers, so that one that always lies is found out before
// anything that it said counts. This class chooses what is looked at and keeps the record; the dispatcher acts on it.
// Pure: the seed is passed in.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "coordinator/dispatch/work.hpp"

namespace coppice {

class CrossCheck {
 public:
  static constexpr std::uint32_t kFirstAnswers = 8;  // of which one unit is computed again, whatever the share

  // `share` of all units, 0 to 1; 0: nothing is checked. `seed` must not be guessed by workers.
  CrossCheck(double share, std::uint64_t seed) : share_(share), random_(seed) {}

  // Which of the `count` units of an answer are to be computed again, in ascending order. Chosen at random: the results
  // do not depend on it, and a liar cannot know.
  std::vector<std::uint32_t> sample(WorkerId worker, std::uint32_t count);

  // Units that counted as the worker said, without a look.
  void took_unchecked(WorkerId worker, std::uint32_t units) { records_[worker].unchecked += units; }
  std::uint64_t unchecked(WorkerId worker) const {
    const auto found = records_.find(worker);
    return found == records_.end() ? 0 : found->second.unchecked;
  }
  // So many of them do not count any more.
  void forget_unchecked(WorkerId worker, std::uint64_t units);
  // Nothing that was taken counts any more.
  void begin_again();

 private:
  struct Record {
    std::uint32_t answers = 0;
    std::uint64_t unchecked = 0;
    double due = 0.0;  // units to check, not yet a whole one
  };

  double share_;
  std::mt19937_64 random_;
  std::map<WorkerId, Record> records_;
};

}  // namespace coppice
