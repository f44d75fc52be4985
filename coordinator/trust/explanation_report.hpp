// What `coppice explain` prints: the costliest states, and the branches that would mend them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/problem/problem.hpp"
#include "coordinator/trust/disagreement.hpp"
#include "coordinator/trust/tree_figures.hpp"

namespace coppice {

// A group's branch, and what the tree would be with it alone, or with all branches up to it, the latest tried first.
struct Suggestion {
  Tree branch;
  std::string edit;  // what `coppice edit` takes to add it: "--insert '0 0 (sequence ...)'"
  TreeFigures alone;
  TreeFigures together;  // behind it the branches of the groups before it
  Tree together_tree;
};

struct ExplainReport {
  Explanation explanation;
  TreeFigures now;
  std::vector<Suggestion> suggestions;  // one a group
};

// REQUIRES: as explain().
ExplainReport explain_report(const Chain& chain, const Tree& tree, const ExplainSettings& settings);

// `most_states`: how many of the costliest states are listed.
std::string to_text(const ExplainReport& report, const Chain& chain, const Tree& tree, const Problem& problem,
                    std::size_t most_states);
nlohmann::ordered_json to_json(const ExplainReport& report, const Chain& chain, const Tree& tree,
                               std::size_t most_states);

}  // namespace coppice
