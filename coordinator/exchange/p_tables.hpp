// Gymnasium's tables P[state][action] = [(probability, next state, reward, terminated), ...] as JSON:
//
//   {"format": "coppice-tables-1", "title": ..., "features": [...], "actions": [...], "observations": [[...] per
//   state],
//    "initial": [probability per state], "P": [[[[p, next, reward, terminated], ...] per action] per state]}
//
// or the bare tables, as lists or as objects with the numbers as keys. Successors of one list that repeat are added up;
// a reward belongs to the successor, and the row's is the mean. What follows a terminated step is never looked at: its
// next state becomes a terminal one, a copy of its own where steps that go on lead there, too. An action may be empty:
// the state lacks it. Memory: the tables as numbers, not as JSON.
#pragma once

#include <optional>
#include <string>

#include "common/error.hpp"
#include "coordinator/exchange/model.hpp"
#include "coordinator/exchange/source_header.hpp"

namespace coppice {

struct TablesSource {
  Model model;  // without starts where the file has no "initial"
  SourceHeader header;
};

// `collision_reward`: a step with this reward or less is a collision. Errors name the file, the state and action or the
// place in the JSON, what was found and what was expected.
Result<TablesSource> read_p_tables(const std::string& path, std::optional<double> collision_reward);

}  // namespace coppice
