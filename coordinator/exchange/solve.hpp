// Solving a model: the policy that earns most and the value of every action.
//
// Discounted: Q(s, a) = r(s, a) + gamma x sum over s' of p(s' | s, a) V(s'), V(s) = max over a of Q(s, a), by modified
// policy iteration (Puterman and Shin, "Modified policy iteration algorithms for discounted Markov decision problems",
// Management Science 1978): each sweep of improvement over all states in order, Gauss-Seidel, is followed by sweeps
// under the policy found. It ends when no value moves by more than the tolerance; then |V - V*| <= gamma / (1 - gamma)
// x that move (Puterman, Markov Decision Processes, 1994, theorem 6.3.1), the bound that is reported. Over a horizon of
// H steps, undiscounted or not: H sweeps backwards; the policy is the first step's, and what is reported as its value
// is that of taking it in every step.
//
// A model of a log may have counts in place of probabilities, and pairs that are distrusted: those are lacking, to all
// of what follows but occupancy_of_policy(), which wants probabilities.
//
// Arrival in a terminal state ends an episode: its value is 0, whatever its rows say. Sums go in one order: the same
// model gives the same bits. One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "common/error.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/exchange/model.hpp"

namespace coppice {

inline constexpr double kMaxSolvedGamma = 0.999999;
inline constexpr std::uint32_t kMaxHorizon = 1'000'000;
inline constexpr std::uint32_t kMaxSweeps = 10'000'000;

struct SolveSettings {
  double gamma = 0.99;                        // in [0, kMaxSolvedGamma]; with a horizon in [0, 1]
  std::optional<std::uint32_t> horizon = {};  // steps, 1 to kMaxHorizon; none: for ever
  double tolerance = 1e-10;                   // of a value, relative to the largest or to 1
};
Result<void> check_settings(const SolveSettings& settings);

struct Solution {
  std::vector<double> q;         // [states x actions]; a pair that the model lacks has the state's lowest, or 0
  std::vector<ActionId> policy;  // [states], ties (to within the tolerance) to the lowest index
  std::uint64_t ties = 0;        // states in which another action is as good, terminal ones aside
  std::uint32_t sweeps = 0;
  double residual = 0.0;  // the largest move of a value in the last sweep
  double bound = 0.0;     // of |V - V*|; 0 over a horizon
};

// Called between sweeps, with the residual so far (relative to the tolerance, as a share of the way in logarithms);
// false to stop. May be empty.
using SolveProgress = std::function<bool(double share)>;

// Errors: settings out of range; interrupted; kMaxSweeps without an end. REQUIRES: check_model(model).
Result<Solution> solve(const Model& model, const SolveSettings& settings, const SolveProgress& go_on = {});

// The expected return of a policy from where episodes start, discounted or over the horizon. Errors: as solve().
// REQUIRES: the policy takes an action that the state has, in every state that has one and is not terminal.
Result<double> value_of_policy(const Model& model, const std::vector<ActionId>& policy, const SolveSettings& settings,
                               const SolveProgress& go_on = {});
// The value of every state under it. [states]
Result<std::vector<double>> values_of_policy(const Model& model, const std::vector<ActionId>& policy,
                                             const SolveSettings& settings, const SolveProgress& go_on = {});
// Q of every pair when `values` is what follows. [states x actions], as Solution::q.
std::vector<double> q_of_values(const Model& model, const std::vector<double>& values, double gamma);

// How often each state is visited under the policy, discounted: (1 - gamma) x sum over i of gamma^i P(X_i = s), for a
// gamma of at most kMostRemembered; an episode that ended is nowhere. [states]
inline constexpr double kMostRemembered = 0.999;
std::vector<double> occupancy_of_policy(const Model& model, const std::vector<ActionId>& policy, double gamma);

}  // namespace coppice
