#include "coordinator/exchange/solve.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kSweepsUnderPolicy = 20;  // between two improvements
constexpr double kNegligible = 1e-12;             // of the occupancy, together

constexpr double kNone = -std::numeric_limits<double>::infinity();

class Solver {
 public:
  Solver(const Model& model, double gamma)
      : model_(model), gamma_(gamma), values_(model.states(), 0.0), terminal_(model.states(), false) {
    for (const std::uint32_t state : model.terminals) {
      terminal_[state] = true;
    }
  }

  bool has(std::size_t row) const {
    return model_.row_begin[row + 1] > model_.row_begin[row] && (model_.distrusted.empty() || !model_.distrusted[row]);
  }
  bool decides(std::size_t state) const { return !terminal_[state]; }

  // kNone: the state lacks the action.
  double q(std::size_t row, const std::vector<double>& next) const {
    if (!has(row)) {
      return kNone;
    }
    return model_.reward[row] + gamma_ * (model_.probability.empty() ? mean_by_count(row, next) : mean(row, next));
  }

  double best(std::size_t state, const std::vector<double>& next) const {
    double best = kNone;
    for (std::size_t row = state * model_.actions(); row < (state + 1) * model_.actions(); ++row) {
      best = std::max(best, q(row, next));
    }
    return best == kNone ? 0.0 : best;
  }

  // The value of an action given by index; 0 where the state lacks it.
  double under(std::size_t state, ActionId action, const std::vector<double>& next) const {
    const double value = q(state * model_.actions() + index_of(action), next);
    return value == kNone ? 0.0 : value;
  }

  // One sweep in place; the largest move.
  template <typename ValueOf>
  double sweep(const ValueOf& value_of) {
    double moved = 0.0;
    for (std::size_t state = 0; state < values_.size(); ++state) {
      if (!decides(state)) {
        continue;
      }
      const double value = value_of(state, values_);
      moved = std::max(moved, std::abs(value - values_[state]));
      values_[state] = value;
    }
    return moved;
  }

  // `steps` sweeps from behind, each from the values of the one before.
  template <typename ValueOf>
  Result<void> backwards(std::uint32_t steps, const ValueOf& value_of, const SolveProgress& go_on) {
    std::vector<double> next(values_.size(), 0.0);
    for (std::uint32_t step = 0; step < steps; ++step) {
      next.swap(values_);
      for (std::size_t state = 0; state < values_.size(); ++state) {
        values_[state] = decides(state) ? value_of(state, next) : 0.0;
      }
      if (go_on && !go_on(static_cast<double>(step + 1) / steps)) {
        return stopped();
      }
    }
    return {};
  }

  static tl::unexpected<Error> stopped() {
    return tl::unexpected(Error{ErrorKind::interrupted, "solving was stopped"});
  }

  double scale() const {
    double largest = 1.0;
    for (const double value : values_) {
      largest = std::max(largest, std::abs(value));
    }
    return largest;
  }

  std::vector<double>& values() { return values_; }

 private:
  // Of `next` where the row leads; REQUIRES: has(row).
  double mean(std::size_t row, const std::vector<double>& next) const {
    double sum = 0.0;
    for (std::uint64_t i = model_.row_begin[row]; i < model_.row_begin[row + 1]; ++i) {
      const std::uint32_t successor = model_.successor[i];
      sum += terminal_[successor] ? 0.0 : model_.probability[i] * next[successor];
    }
    return sum;
  }
  double mean_by_count(std::size_t row, const std::vector<double>& next) const {
    double sum = 0.0;
    double tries = 0.0;
    for (std::uint64_t i = model_.row_begin[row]; i < model_.row_begin[row + 1]; ++i) {
      const std::uint32_t successor = model_.successor[i];
      tries += model_.count[i];
      sum += terminal_[successor] ? 0.0 : model_.count[i] * next[successor];
    }
    return sum / tries;
  }

  const Model& model_;
  double gamma_;
  std::vector<double> values_;
  std::vector<bool> terminal_;
};

// Of how far a residual has come on the way to the tolerance.
double share_of_way(double first, double now, double wanted) {
  if (!(first > wanted) || now <= wanted) {
    return 1.0;
  }
  return std::clamp(std::log(first / now) / std::log(first / wanted), 0.0, 1.0);
}

// Repeats `turn` (which gives the largest move of a value) until it moves no more than the tolerance. Beyond a thousand
// times the precision of a double nothing more can be asked for.
template <typename Turn>
Result<double> until_still(Solver& solver, double tolerance, const Turn& turn, std::uint32_t& sweeps,
                           const SolveProgress& go_on) {
  double first = 0.0;
  while (sweeps < kMaxSweeps) {
    const double moved = turn();
    if (!std::isfinite(moved)) {
      return bad_input("values grow beyond all numbers: expected smaller rewards or a smaller discount");
    }
    first = std::max(first, moved);
    const double wanted = std::max(tolerance, 1e-13) * solver.scale();
    if (moved <= wanted) {
      return moved;
    }
    if (go_on && !go_on(share_of_way(first, moved, wanted))) {
      return Solver::stopped();
    }
  }
  return failed(fmt::format("not solved after {} sweeps: expected a smaller discount", kMaxSweeps));
}

}  // namespace

Result<void> check_settings(const SolveSettings& settings) {
  const double most = settings.horizon ? 1.0 : kMaxSolvedGamma;
  if (!(settings.gamma >= 0.0 && settings.gamma <= most)) {
    return bad_input(fmt::format("--gamma is {}: expected 0 to {}{}", settings.gamma, most,
                                 settings.horizon ? "" : ", or 1 with a --horizon"));
  }
  if (settings.horizon && (*settings.horizon == 0 || *settings.horizon > kMaxHorizon)) {
    return bad_input(fmt::format("--horizon is {}: expected 1 to {}", *settings.horizon, kMaxHorizon));
  }
  return {};
}

std::vector<double> q_of_values(const Model& model, const std::vector<double>& values, double gamma) {
  const Solver solver(model, gamma);
  std::vector<double> q(model.rows(), 0.0);
  for (std::size_t state = 0; state < model.states(); ++state) {
    if (!solver.decides(state)) {
      continue;
    }
    double lowest = std::numeric_limits<double>::infinity();
    for (std::size_t row = state * model.actions(); row < (state + 1) * model.actions(); ++row) {
      q[row] = solver.q(row, values);
      lowest = q[row] == kNone ? lowest : std::min(lowest, q[row]);
    }
    for (std::size_t row = state * model.actions(); row < (state + 1) * model.actions(); ++row) {
      q[row] = q[row] != kNone ? q[row] : (std::isinf(lowest) ? 0.0 : lowest);
    }
  }
  return q;
}

namespace {

// The greedy policy of q among the actions that a state has; counts the states where it had a choice.
void choose_greedily(const Model& model, const Solver& solver, double tolerance, Solution& solution) {
  solution.policy.assign(model.states(), ActionId{0});
  for (std::size_t state = 0; state < model.states(); ++state) {
    const std::size_t first = state * model.actions();
    double best = kNone;
    for (std::size_t row = first; row < first + model.actions(); ++row) {
      best = solver.has(row) ? std::max(best, solution.q[row]) : best;
    }
    const double near = tolerance * std::max(1.0, std::abs(best));
    std::uint32_t as_good = 0;
    for (std::size_t action = model.actions(); action-- > 0;) {
      if (solver.has(first + action) && solution.q[first + action] >= best - near) {
        solution.policy[state] = ActionId{static_cast<std::uint8_t>(action)};
        ++as_good;
      }
    }
    solution.ties += as_good > 1 && solver.decides(state) ? 1 : 0;
  }
}

}  // namespace

Result<Solution> solve(const Model& model, const SolveSettings& settings, const SolveProgress& go_on) {
  if (auto ok = check_settings(settings); !ok) {
    return tl::unexpected(ok.error());
  }
  Solver solver(model, settings.gamma);
  const auto best = [&](std::size_t state, const std::vector<double>& next) { return solver.best(state, next); };
  Solution solution;
  // Values that differ by less than what solving leaves open are equal.
  constexpr double kTieTolerance = 1e-9;
  if (settings.horizon) {
    if (auto ok = solver.backwards(*settings.horizon - 1, best, go_on); !ok) {
      return tl::unexpected(ok.error());
    }
    solution.sweeps = *settings.horizon;
    solution.q = q_of_values(model, solver.values(), settings.gamma);
    choose_greedily(model, solver, kTieTolerance, solution);
    return solution;
  }
  std::vector<ActionId> policy(model.states(), ActionId{0});
  const auto turn = [&] {
    const double moved = solver.sweep([&](std::size_t state, const std::vector<double>& values) {
      double highest = kNone;
      for (std::size_t action = 0; action < model.actions(); ++action) {
        const double value = solver.q(state * model.actions() + action, values);
        if (value > highest) {
          highest = value;
          policy[state] = ActionId{static_cast<std::uint8_t>(action)};
        }
      }
      return highest == kNone ? 0.0 : highest;
    });
    for (std::uint32_t sweep = 0; sweep < kSweepsUnderPolicy; ++sweep) {
      solver.sweep([&](std::size_t state, const std::vector<double>& values) {
        return solver.under(state, policy[state], values);
      });
    }
    solution.sweeps += 1 + kSweepsUnderPolicy;
    return moved;
  };
  const auto residual = until_still(solver, settings.tolerance, turn, solution.sweeps, go_on);
  if (!residual) {
    return tl::unexpected(residual.error());
  }
  // What is reported is measured on the values that are returned.
  solution.residual = solver.sweep(best);
  solution.bound = settings.gamma / (1.0 - settings.gamma) * solution.residual;
  solution.q = q_of_values(model, solver.values(), settings.gamma);
  choose_greedily(model, solver, std::max(kTieTolerance, solution.bound), solution);
  return solution;
}

Result<std::vector<double>> values_of_policy(const Model& model, const std::vector<ActionId>& policy,
                                             const SolveSettings& settings, const SolveProgress& go_on) {
  COPPICE_CHECK(policy.size() == model.states());
  if (auto ok = check_settings(settings); !ok) {
    return tl::unexpected(ok.error());
  }
  Solver solver(model, settings.gamma);
  const auto under = [&](std::size_t state, const std::vector<double>& next) {
    return solver.under(state, policy[state], next);
  };
  if (settings.horizon) {
    if (auto ok = solver.backwards(*settings.horizon, under, go_on); !ok) {
      return tl::unexpected(ok.error());
    }
    return std::move(solver.values());
  }
  std::uint32_t sweeps = 0;
  const auto turn = [&] {
    ++sweeps;
    return solver.sweep(under);
  };
  // The move that is left is worth up to 1 / (1 - gamma) of it.
  const auto moved = until_still(solver, settings.tolerance * (1.0 - settings.gamma), turn, sweeps, go_on);
  if (!moved) {
    return tl::unexpected(moved.error());
  }
  return std::move(solver.values());
}

Result<double> value_of_policy(const Model& model, const std::vector<ActionId>& policy, const SolveSettings& settings,
                               const SolveProgress& go_on) {
  const auto values = values_of_policy(model, policy, settings, go_on);
  if (!values) {
    return tl::unexpected(values.error());
  }
  double value = 0.0;
  for (const ModelStart& start : model.starts) {
    value += start.probability * (*values)[start.state];
  }
  return value;
}

std::vector<double> occupancy_of_policy(const Model& model, const std::vector<ActionId>& policy, double gamma) {
  gamma = std::min(gamma, kMostRemembered);
  std::vector<double> occupancy(model.states(), 0.0);
  std::vector<double> now(model.states(), 0.0);
  for (const ModelStart& start : model.starts) {
    now[start.state] = start.probability;
  }
  std::vector<bool> terminal(model.states(), false);
  for (const std::uint32_t state : model.terminals) {
    terminal[state] = true;
  }
  std::vector<double> next(model.states());
  double weight = 1.0 - gamma;
  while (weight > kNegligible * (1.0 - gamma)) {  // gamma < 1: it ends
    std::fill(next.begin(), next.end(), 0.0);
    for (std::size_t state = 0; state < now.size(); ++state) {
      occupancy[state] += weight * now[state];
      if (now[state] == 0.0 || terminal[state]) {
        continue;
      }
      const std::size_t row = state * model.actions() + index_of(policy[state]);
      for (std::uint64_t i = model.row_begin[row]; i < model.row_begin[row + 1]; ++i) {
        next[model.successor[i]] += now[state] * model.probability[i];
      }
    }
    now.swap(next);
    weight *= gamma;
  }
  return occupancy;
}

}  // namespace coppice
