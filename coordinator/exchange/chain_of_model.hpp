// A model and its policy turned into a chain: names and readings into a vocabulary, probabilities into counts, terminal
// states into rows that stay or start again.
#pragma once

#include <vector>

#include "common/error.hpp"
#include "coordinator/exchange/imported.hpp"
#include "coordinator/exchange/model.hpp"
#include "coordinator/exchange/problem_file.hpp"
#include "coordinator/exchange/solve.hpp"

namespace coppice {

// What a policy is worth, as far as a chain keeps it.
struct PolicyOfModel {
  std::vector<double> q;         // [states x actions], finite
  std::vector<ActionId> policy;  // [states]
  std::vector<double> weight;    // [states], how often it visits each, >= 0
};

struct ModelValuation {
  SolveSettings settings;
  bool known = false;  // settings.gamma or the horizon were said
};

// Collisions, terminal states and starts as a problem file wants them, in the model. Errors: a test, label or state
// that does not fit.
Result<void> apply_problem(const ProblemFile& file, Model& model);

// Look-alikes become one state: rows are the means of theirs, weighted by visits, and so is Q; the policy is what it
// does most. Terminal states only join terminal ones. REQUIRES: check_model(model); sizes of `policy` fit.
struct Merged {
  Model model;
  PolicyOfModel policy;
  std::vector<std::uint32_t> state_of;  // [states before], the state that each became
};
Merged merge_look_alikes(const Model& model, const PolicyOfModel& policy);

// Errors: a wish for a feature or action that the model has not; more readings than a feature can have; what
// Chain::make() refuses. REQUIRES: check_model(model); sizes of `policy` fit; the policy takes actions that the states
// have.
Result<Imported> chain_of_model(Model model, PolicyOfModel policy, const ProblemFile& file,
                                const ModelValuation& valuation, const SolveProgress& go_on = {});

}  // namespace coppice
