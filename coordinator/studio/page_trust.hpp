// What a tree promises and where it falls short, for the page: figures with intervals, on the chain and in the
// simulator, for tree and policy; rules; disagreements; and the sentences that say what is not good enough. Fields:
// README.md, "promise", "rules", "disagreements", "shortfalls".
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/report/score.hpp"
#include "coordinator/trust/rule.hpp"
#include "coordinator/trust/verification.hpp"

namespace coppice {

// Of a chain of more states figures have no intervals and branches are not suggested: both would take hours.
inline constexpr std::size_t kMostTrustedStates = 20'000;

struct Promise {
  std::optional<Verification> tree;               // nothing: the chain is too large
  std::optional<ControllerScore> tree_simulated;  // nothing: the study has no simulator
  std::optional<ControllerScore> policy_simulated;
};

struct PromiseSettings {
  SimulateSettings simulate;
  std::uint32_t resamples = 100;
};

// Asked now and then, with the share that is done in [0, 1]; false to stop. May be empty.
using PageProgress = std::function<bool(double share)>;

// `world`: nullptr where the study has none; its kind by `world_kind` (StudyWorld::kind). Errors: interrupted.
Result<Promise> promise_of(const World* world, const std::string& world_kind, const Chain& chain, const Tree& tree,
                           const PromiseSettings& settings, const PageProgress& go_on);
nlohmann::ordered_json to_json(const Promise& promise);

// In plain words what a designer must know before trusting the tree, worst first; empty: nothing was found.
// figures, policy: "figures" of tree_json() and policy_json(); view: "view" of tree_json().
std::vector<std::string> shortfalls_of(const Promise& promise, const nlohmann::ordered_json& figures,
                                       const nlohmann::ordered_json& policy, const nlohmann::ordered_json& view);

// Rules that everybody wants to hold: it always chooses an action; in a room it never moves into a wall ahead.
std::vector<std::string> default_rules(const std::string& world_kind);

// One rule as text, checked: what to_json(CheckedRule) says with the observation as values; or {"rule", "error"}.
nlohmann::ordered_json rule_json(const std::string& text, const Tree& tree, const Chain& chain);

// Where tree and policy differ, the costliest states first, and the branches that would mend most of it.
nlohmann::ordered_json disagreements_json(const Chain& chain, const Tree& tree, std::uint32_t steps);

}  // namespace coppice
