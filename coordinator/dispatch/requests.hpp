// The requests that are open and what is known of each: its outcomes so far, and whose word each of them is. Where its
// units are is in the in-flight table (InFlight). Pure.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <vector>

#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/work.hpp"

namespace coppice {

// How a request is to be dispatched.
struct RequestTerms {
  WorkClass work;
  std::uint32_t most_per_batch = 1;  // units in one message
  std::uint32_t expected = 0;        // so many units will be added, at most
};

struct OpenRequest {
  RequestTerms terms;
  bool sealed = false;                // no more units come
  std::vector<UnitOutcome> outcomes;  // [units]
  std::vector<WorkerId> believed;     // [units] whose word the outcome is; kHome: checked, or computed here
  std::uint32_t undecided = 0;        // computations under way that may change outcomes
  std::uint64_t repeated = 0;         // units that workers found to be the same as others
  InFlight::Time begun;

  std::uint32_t units() const { return static_cast<std::uint32_t>(outcomes.size()); }
  std::uint32_t coming() const { return sealed || terms.expected < units() ? 0 : terms.expected - units(); }
  // Places whose outcome is that worker's word.
  std::vector<std::uint32_t> believed_of(WorkerId worker) const {
    std::vector<std::uint32_t> places;
    for (std::uint32_t place = 0; place < units(); ++place) {
      if (believed[place] == worker) {
        places.push_back(place);
      }
    }
    return places;
  }
};

using OpenRequests = std::map<RequestId, OpenRequest>;

}  // namespace coppice
