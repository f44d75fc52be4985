// Trust in workers' answers: a share of what they evaluated is evaluated here again, by the kernel that is the
// reference for everybody. A worker that answered wrongly, even once, is found out; what else it said can then be
// evaluated here. We differ: a second worker's opinion would spare the coordinator's core, but two workers of one
// broken build agree.
//
// A worker that is new gives a sample of each of its first answers, so that one that always lies is found out before
// anything that it said counts. Without DDS; belongs to the dispatching thread.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/stop.hpp"
#include "coordinator/dispatch/evaluator.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/remote_request.hpp"

namespace coppice {

class CrossCheck {
 public:
  static constexpr std::uint32_t kFirstAnswers = 8;  // of which one individual is evaluated again, whatever the share

  // `share` of all individuals, 0 to 1; 0: nothing is checked. The chain is prepared for evaluation when first needed.
  // `stop` outlives it.
  CrossCheck(std::shared_ptr<const Chain> chain, double share, const StopFlag& stop)
      : chain_(std::move(chain)), share_(share), stop_(stop), random_(std::random_device{}()) {}

  // Which of the `count` individuals of an answer are to be evaluated again, in ascending order. Chosen at random: the
  // results do not depend on it, and a liar cannot know.
  std::vector<std::uint32_t> sample(WorkerId worker, std::uint32_t count);
  // Whether that individual of the answer that was last sampled was in the sample.
  bool was_sampled(std::uint32_t individual) const;

  // So many were.
  std::size_t sampled() const { return last_sample_.size(); }

  // Whether a sample of an answer comes out here as the worker said; the answer is to what `request` sent from its
  // place `first` on. True, too, when the evaluation here was interrupted: whoever asks looks at the stop flag
  // afterwards, and believes nothing that is open.
  bool agrees(WorkerId from, std::span<const Tally> tallies, const RemoteRequest& request, std::uint32_t first);
  // Evaluates here what counts as that worker said, unless interrupted, as agrees(). Returns how many.
  std::size_t redo(RemoteRequest& request, WorkerId from);

  // Individuals that counted as the worker said, without a look.
  void took_unchecked(WorkerId worker, std::uint32_t individuals) { records_[worker].unchecked += individuals; }
  std::uint64_t unchecked(WorkerId worker) { return records_[worker].unchecked; }
  // Nothing that was taken counts any more.
  void begin_again();

 private:
  // What the request sent at these places, truly.
  Result<std::vector<Tally>> evaluate(const RemoteRequest& request, std::span<const std::uint32_t> places);

  struct Record {
    std::uint32_t answers = 0;
    std::uint64_t unchecked = 0;
    double due = 0.0;  // individuals to check, not yet a whole one
  };

  std::shared_ptr<const Chain> chain_;
  double share_;
  const StopFlag& stop_;
  std::mt19937_64 random_;
  std::unique_ptr<Evaluator> reference_;
  std::map<WorkerId, Record> records_;
  std::vector<std::uint32_t> last_sample_;
};

}  // namespace coppice
