// What an import gives: a chain, its problem, and what is to be said about how they came about. A plain value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/chain/chain.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {

struct ImportReport {
  std::string format;
  // The policy's expected return from where episodes start, discounted or over the horizon, before rounding to counts;
  // none: nobody said the discount.
  std::optional<double> value;
  std::optional<double> count_error;       // what rounding to counts changed of it
  std::uint64_t lost_transitions = 0;      // whose probability was too small for a count
  std::uint64_t unreachable_states = 0;    // left out
  std::uint64_t ties = 0;                  // states in which several actions are as good
  std::optional<std::uint32_t> sweeps;     // solving
  std::optional<double> bound;             // of the error of a solved value
  std::uint64_t merged_states = 0;         // look-alikes that became one
  std::optional<double> merged_value;      // of the policy that has to take one action in all of them
  std::uint64_t look_alikes = 0;           // states that read the same as another one and were kept apart
  std::uint64_t steps = 0;                 // of a log
  std::uint64_t episodes = 0;              // of a log
  std::uint64_t truncated = 0;             // episodes of a log that were cut off
  std::uint64_t never_tried = 0;           // pairs of a log without a step
  std::uint64_t solved_on_one_try = 0;     // states of a log whose solved action was tried once
  std::uint64_t distrusted = 0;            // pairs of a log that solving was not to take
  std::uint64_t contradictions = 0;        // states of a log in which the recorded policy took different actions
  std::optional<double> bin_disagreement;  // share of the steps of a log whose action is not the one of their state
  std::vector<std::string> notes;          // anything else, a sentence each
};

struct Imported {
  Chain chain;
  Problem problem;
  ImportReport report;
};

}  // namespace coppice
