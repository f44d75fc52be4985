// Everything that the page shows about a study and one tree of it, as one JSON document: the report holds it, the
// studio serves it. README.md says what every field means. Reads the study; writes nothing. One thread.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/studio/page_trust.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

inline constexpr int kPageDataVersion = 1;  // raised when a field changes its meaning or goes

struct PageRequest {
  Tree tree;
  std::string tree_from;           // where it is from, in words: "run 1, pruned from 20 nodes"
  SimulateSettings simulate;       // steps are those of all walks, on the chain too
  std::uint32_t resamples = 100;   // behind the intervals of the chain's figures
  std::string simulator{};         // a command, instead of what the study has; empty: that
  std::vector<std::string> rules;  // to prove; a malformed one is shown as such
  std::string machine;             // on which this is computed, in words
  std::string command;             // that makes this report
};

// `command`, if there is one, else the problem's own simulator, else our world's; nothing: there is none. Errors: a
// world that cannot be made.
Result<std::optional<World>> simulator_of(const Study& study, const std::string& command);

// Errors: the study's; settings out of range, by their flag; a world that cannot be made; interrupted.
// REQUIRES: check_tree(request.tree, study.chain().vocabulary()).
Result<nlohmann::ordered_json> page_data(const Study& study, const PageRequest& request, const PageProgress& go_on);

}  // namespace coppice
