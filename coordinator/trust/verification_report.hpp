// What `coppice verify` prints: figures with their intervals, and rules with their answers.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/problem/problem.hpp"
#include "coordinator/trust/rule_check.hpp"
#include "coordinator/trust/size_bound.hpp"
#include "coordinator/trust/verification.hpp"

namespace coppice {

struct CheckedRule {
  Rule rule;
  RuleAnswer answer;
  std::size_t states = 0;  // of the chain, to which the rule applies
  // The state that breaks it and that learning visited most; nothing: the chain has none.
  std::optional<std::size_t> seen;
};

// check_rule() and where the chain breaks it. Errors: as check_rule().
Result<CheckedRule> check_on(const Rule& rule, const Tree& tree, const Chain& chain);

// Lines. `simulated`: beside the chain's figures those of the simulator.
std::string to_text(const Verification& verification, const std::optional<Simulated>& simulated);
std::string to_text(const SizeBound& bound);
std::string to_text(const CheckedRule& checked, const Tree& tree, const Chain& chain, const Problem& problem);
nlohmann::ordered_json to_json(const Verification& verification, const std::optional<Simulated>& simulated);
nlohmann::ordered_json to_json(const SizeBound& bound);
nlohmann::ordered_json to_json(const CheckedRule& checked, const Tree& tree, const Chain& chain);

// The tree as lines of "number, indent, node", the numbers being what other commands call nodes by; behind a condition
// or action what it says in words, where the problem has labels, and the node's remark, if any.
std::string numbered(const Tree& tree, const Vocabulary& vocabulary, const Problem& problem,
                     const std::vector<std::string>& remarks = {});

// "s0=1 s3=0" of a state or an observation; of those in `shown` only, if given.
std::string observation_text(const Vocabulary& vocabulary, std::span<const std::uint8_t> features,
                             const std::vector<bool>& shown = {});

}  // namespace coppice
