// Solving against enumeration of all policies, each valued by elimination, and against closed forms.
#include "coordinator/exchange/solve.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "common/chain/random.hpp"

namespace coppice {
namespace {

// A model with one feature, the state's number; some pairs lacking, some states terminal.
Model random_model(std::uint64_t seed, std::uint32_t states, std::uint32_t actions) {
  Xoshiro256 random(seed);
  Model model;
  model.feature_names = {"state"};
  for (std::uint32_t a = 0; a < actions; ++a) {
    model.action_names.push_back("a" + std::to_string(a));
  }
  ModelRows rows;
  for (std::uint32_t state = 0; state < states; ++state) {
    model.readings.push_back(state);
    for (std::uint32_t action = 0; action < actions; ++action) {
      if (action > 0 && random.below(5) == 0) {
        continue;
      }
      std::vector<ModelTransition> row;
      const std::uint64_t successors = 1 + random.below(3);
      double sum = 0.0;
      for (std::uint64_t i = 0; i < successors; ++i) {
        row.push_back({static_cast<std::uint32_t>(random.below(states)), 0.1 + static_cast<double>(random.below(9))});
        sum += row.back().probability;
      }
      for (ModelTransition& transition : row) {
        transition.probability /= sum;
      }
      EXPECT_TRUE(rows.add(state, action, static_cast<double>(random.below(2001)) / 100.0 - 10.0, row).has_value());
    }
  }
  EXPECT_TRUE(rows.fill(states, actions, model).has_value());
  model.terminals = {states - 1};
  model.starts = {{0, 0.25}, {1, 0.75}};
  EXPECT_TRUE(check_model(model).has_value());
  return model;
}

bool has(const Model& model, std::size_t row) { return model.row_begin[row + 1] > model.row_begin[row]; }

// Values of a policy by Gauss elimination of (I - gamma P) V = r.
std::vector<double> eliminated(const Model& model, const std::vector<ActionId>& policy, double gamma) {
  const std::size_t n = model.states();
  std::vector<std::vector<double>> a(n, std::vector<double>(n + 1, 0.0));
  for (std::size_t s = 0; s < n; ++s) {
    a[s][s] = 1.0;
    if (model.is_terminal(static_cast<std::uint32_t>(s))) {
      continue;
    }
    const std::size_t row = s * model.actions() + index_of(policy[s]);
    a[s][n] = model.reward[row];
    for (std::uint64_t i = model.row_begin[row]; i < model.row_begin[row + 1]; ++i) {
      a[s][model.successor[i]] -= gamma * model.probability[i];
    }
  }
  for (std::size_t pivot = 0; pivot < n; ++pivot) {
    for (std::size_t row = 0; row < n; ++row) {
      if (row != pivot) {
        const double factor = a[row][pivot] / a[pivot][pivot];
        for (std::size_t column = pivot; column <= n; ++column) {
          a[row][column] -= factor * a[pivot][column];
        }
      }
    }
  }
  std::vector<double> values(n);
  for (std::size_t s = 0; s < n; ++s) {
    values[s] = model.is_terminal(static_cast<std::uint32_t>(s)) ? 0.0 : a[s][n] / a[s][s];
  }
  return values;
}

// Calls each(policy) for all deterministic policies.
template <typename Each>
void each_policy(const Model& model, const Each& each) {
  std::vector<ActionId> policy(model.states(), ActionId{0});
  while (true) {
    each(policy);
    std::size_t state = 0;
    for (; state < policy.size(); ++state) {
      std::size_t next = index_of(policy[state]) + 1;
      while (next < model.actions() && !has(model, state * model.actions() + next)) {
        ++next;
      }
      if (next < model.actions()) {
        policy[state] = ActionId{static_cast<std::uint8_t>(next)};
        break;
      }
      policy[state] = ActionId{0};
    }
    if (state == policy.size()) {
      return;
    }
  }
}

TEST(Solve, FindsTheBestOfAllPoliciesWithinItsBound) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Model model = random_model(seed, 6, 3);
    for (const double gamma : {0.0, 0.5, 0.95}) {
      std::vector<double> best(model.states(), -1e300);
      each_policy(model, [&](const std::vector<ActionId>& policy) {
        const std::vector<double> values = eliminated(model, policy, gamma);
        for (std::size_t s = 0; s < values.size(); ++s) {
          best[s] = std::max(best[s], values[s]);
        }
      });
      const auto solution = solve(model, {.gamma = gamma});
      ASSERT_TRUE(solution.has_value()) << solution.error().message;
      EXPECT_LT(solution->bound, 1e-7);
      const std::vector<double> found = eliminated(model, solution->policy, gamma);
      for (std::size_t s = 0; s < found.size(); ++s) {
        EXPECT_NEAR(found[s], best[s], 1e-7) << seed << " " << gamma << " " << s;
        EXPECT_TRUE(model.is_terminal(static_cast<std::uint32_t>(s)) ||
                    has(model, s * model.actions() + index_of(solution->policy[s])));
        double highest = -1e300;
        for (std::size_t a = 0; a < model.actions(); ++a) {
          highest = std::max(highest, solution->q[s * model.actions() + a]);
        }
        EXPECT_NEAR(highest, best[s], 1e-7 + solution->bound);
      }
      const double from_start = 0.25 * best[0] + 0.75 * best[1];
      EXPECT_NEAR(*value_of_policy(model, solution->policy, {.gamma = gamma}), from_start, 1e-7);
    }
  }
}

TEST(Solve, OverAHorizonTheFirstStepIsBackwardInduction) {
  const Model model = random_model(3, 6, 3);
  std::vector<double> values(model.states(), 0.0);
  constexpr std::uint32_t kHorizon = 7;
  std::vector<double> q(model.rows(), 0.0);
  for (std::uint32_t step = 0; step < kHorizon; ++step) {
    std::vector<double> next(model.states(), 0.0);
    for (std::size_t s = 0; s + 1 < model.states(); ++s) {
      double best = -1e300;
      for (std::size_t a = 0; a < model.actions(); ++a) {
        const std::size_t row = s * model.actions() + a;
        if (!has(model, row)) {
          continue;
        }
        q[row] = model.reward[row];
        for (std::uint64_t i = model.row_begin[row]; i < model.row_begin[row + 1]; ++i) {
          q[row] += model.probability[i] * values[model.successor[i]];
        }
        best = std::max(best, q[row]);
      }
      next[s] = best;
    }
    values = next;
  }
  const auto solution = solve(model, {.gamma = 1.0, .horizon = kHorizon});
  ASSERT_TRUE(solution.has_value()) << solution.error().message;
  for (std::size_t row = 0; row < q.size(); ++row) {
    if (has(model, row) && row / model.actions() + 1 < model.states()) {
      EXPECT_NEAR(solution->q[row], q[row], 1e-10) << row;
    }
  }
}

TEST(Solve, OccupancyIsTheDiscountedShareOfVisits) {
  const Model model = random_model(5, 6, 2);
  const std::vector<ActionId> policy(model.states(), ActionId{0});
  constexpr double kGamma = 0.9;
  const std::vector<double> occupancy = occupancy_of_policy(model, policy, kGamma);
  // By duality sum of occupancy x reward / (1 - gamma) is the value.
  double value = 0.0;
  for (std::size_t s = 0; s + 1 < model.states(); ++s) {
    value += occupancy[s] * model.reward[s * model.actions()];
  }
  EXPECT_NEAR(value / (1.0 - kGamma), *value_of_policy(model, policy, {.gamma = kGamma}), 1e-9);
}

TEST(Solve, WrongSettingsAreRefusedAndAStopIsHeeded) {
  const Model model = random_model(1, 6, 2);
  EXPECT_NE(solve(model, {.gamma = 1.0}).error().message.find("--gamma is 1"), std::string::npos);
  EXPECT_NE(solve(model, {.gamma = -0.1}).error().message.find("--gamma is -0.1"), std::string::npos);
  EXPECT_NE(solve(model, {.gamma = 1.0, .horizon = 0}).error().message.find("--horizon is 0"), std::string::npos);
  const auto stopped = solve(model, {.gamma = 0.99}, [](double) { return false; });
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().kind, ErrorKind::interrupted);
}

}  // namespace
}  // namespace coppice
