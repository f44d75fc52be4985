// Proves a rule about a tree for every observation that the vocabulary allows, or finds one that breaks it; and says
// which nodes decide, which is the verification argument of the thesis (VII, "Easy verification") made exact.
//
// Method: symbolic execution (King, "Symbolic execution and program testing", CACM 1976) of the tick as a program
// without loops (jumps.hpp). A state is the leaf that comes next, the node that wrote last, and for each feature which
// of its values are still possible; values that no test tells apart are one. A test splits a state only where it can go
// both ways, and what was learned about a feature is forgotten when no later leaf tests it, so that states that will do
// the same from here on become one: the number of states follows the tree's tests, not the 2^k observations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/trust/rule.hpp"

namespace coppice {

inline constexpr std::size_t kMaxRuleStates = std::size_t{1} << 21U;  // beyond, check_rule() gives up

// What a node does in the ticks that the rule is about.
struct NodeRole {
  bool ticked = false;     // in some of them
  bool succeeds = false;   // leaves: in some of them
  bool fails = false;      // conditions: in some of them
  bool last_word = false;  // actions: in some of them it writes last
};

struct Counterexample {
  std::vector<std::uint8_t> features;  // one value for each
  std::vector<bool> matters;           // [features] tested on the way or by the rule; the others may be anything
  ActionId action = kNoAction;         // what the tree does there
  std::size_t writer = 0;              // the node that writes it; kTickEnds when none does
};

struct RuleAnswer {
  std::optional<Counterexample> broken;  // empty: it holds
  std::vector<NodeRole> nodes;           // [nodes of the tree]
  std::size_t states = 0;                // that the proof took

  bool holds() const { return !broken.has_value(); }
  std::size_t ticked() const;
};

// Errors (failed): the proof would take more than kMaxRuleStates states.
// REQUIRES: check_tree(tree, vocabulary), a rule of that vocabulary.
Result<RuleAnswer> check_rule(const Rule& rule, const Tree& tree, const Vocabulary& vocabulary);

}  // namespace coppice
