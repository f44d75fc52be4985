// The requests that are open and where their trees are in the books: a portion of a request is a generation of
// InFlight. Without DDS; belongs to the dispatching thread.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "common/fitness/job.hpp"
#include "common/fitness/meaning.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/remote_request.hpp"
#include "coordinator/dispatch/schedule.hpp"

namespace coppice {

enum class RequestId : std::uint64_t {};

class RemoteRequests {
 public:
  // `flight` outlives it.
  explicit RemoteRequests(InFlight& flight) : flight_(flight) {}

  // The trees outlive the request.
  RequestId open(std::span<const Tree> trees, const Job& job, bool seek_repeats);
  // Looks at the next trees of every request and puts what is to be sent into the books.
  void see_portions(Meanings& meanings);
  bool all_seen() const;
  // Everything of it was seen and settled.
  bool done(RequestId id) const;
  const RemoteRequest& at(RequestId id) const { return open_.at(id).request; }

  struct Finished {
    std::vector<Tally> tallies;  // in the order of the trees
    std::uint64_t repeated = 0;  // DispatchStatistics
  };
  // Ends it. REQUIRES: done(id).
  Finished take(RequestId id);
  // Ends all.
  void abandon();

  // Where the first slot of a batch, or a slot, is in its request's order of sending. REQUIRES: its generation has not
  // ended.
  struct Place {
    RemoteRequest& request;
    std::uint32_t first = 0;
  };
  Place place_of(const Batch& batch) { return place_of(Slot{batch.generation, batch.first}); }
  Place place_of(const Slot& slot);

  bool empty() const { return open_.empty(); }
  std::size_t size() const { return open_.size(); }
  // Calls `each` with every open request.
  template <typename Each>
  void for_each(const Each& each) {
    for (auto& [id, open] : open_) {
      each(open.request);
    }
  }

  // Of an individual: of the request with the longest walks, and of the one whose slots go out next. 0: none is open.
  std::uint64_t most_steps() const;
  std::uint64_t steps_at_front() const;
  // What a batch may hold, and how many individuals are still to come. `most`: more must not be sent at once.
  Horizon horizon(std::uint32_t most) const;

 private:
  struct Open {
    RemoteRequest request;
    std::vector<GenerationId> portions;
  };
  // What a generation of the books holds: of this request, from this place on.
  struct Portion {
    RequestId request{};
    std::uint32_t first = 0;
  };
  void close(std::map<RequestId, Open>::iterator open);

  InFlight& flight_;
  std::map<RequestId, Open> open_;
  std::map<GenerationId, Portion> portions_;
  std::uint64_t next_ = 1;
};

}  // namespace coppice
