#include "common/fitness/objective.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "common/check.hpp"
#include "common/tree/condition.hpp"

namespace coppice {
namespace {

Result<void> check_rules(const Chain& chain, const std::vector<ShapedRule>& rules) {
  if (rules.empty() || rules.size() > kMaxShapedRules) {
    return bad_input(fmt::format("objective 'shaped' has {} rules: expected 1 to {}", rules.size(), kMaxShapedRules));
  }
  for (std::size_t i = 0; i < rules.size(); ++i) {
    if (rules[i].any_of.size() > kMaxShapedConditions) {
      return bad_input(fmt::format("objective 'shaped': rule {} has {} conditions: expected at most {}", i + 1,
                                   rules[i].any_of.size(), kMaxShapedConditions));
    }
    for (const Node& condition : rules[i].any_of) {
      auto leaf = Tree::from_nodes({condition});
      if (!leaf || condition.kind != NodeKind::condition) {
        return bad_input(fmt::format("objective 'shaped': rule {} holds a node that is not a condition", i + 1));
      }
      if (auto ok = check_tree(*leaf, chain.vocabulary()); !ok) {
        return in_context(fmt::format("objective 'shaped': rule {}", i + 1), ok.error());
      }
    }
  }
  return {};
}

// `one` where the values are no larger than `fine`; else less, by a power of two, as many times as they are larger.
double unit_for(double largest, double fine, double one) {
  while (largest > fine) {  // ends: largest is finite
    largest /= 2.0;
    one /= 2.0;
  }
  return one;
}

class TableMaker {
 public:
  TableMaker(const Chain& chain, const Objective& objective) : chain_(chain), objective_(objective) {
    table_.scores.assign(chain.states() * (chain.actions() + 1), 0);
  }

  Result<ScoreTable> make() {
    if (!(std::abs(objective_.threshold) <= kMaxThreshold)) {
      return bad_input(fmt::format("objective '{}' has threshold {}: expected within +-{}", name_of(objective_.kind),
                                   objective_.threshold, kMaxThreshold));
    }
    switch (objective_.kind) {
      case ObjectiveKind::agreement:
      case ObjectiveKind::coverage:
        for (std::size_t s = 0; s < chain_.states(); ++s) {
          at(s, index_of(chain_.policy(s))) = 1;
        }
        break;
      case ObjectiveKind::visits:
        for (std::size_t s = 0; s < chain_.states(); ++s) {
          at(s, index_of(chain_.policy(s))) = static_cast<std::int64_t>(chain_.parts().visits[s]);
        }
        break;
      case ObjectiveKind::shaped:
        if (auto ok = fill_shaped(); !ok) {
          return tl::unexpected(ok.error());
        }
        break;
      case ObjectiveKind::q_value:
      case ObjectiveKind::expected_return:
        if (auto ok = fill_values(); !ok) {
          return tl::unexpected(ok.error());
        }
        break;
      case ObjectiveKind::regret:
        if (auto ok = fill_regret(); !ok) {
          return tl::unexpected(ok.error());
        }
        break;
      case ObjectiveKind::seen:
        for (std::size_t s = 0; s < chain_.states(); ++s) {
          const bool seen = static_cast<double>(chain_.parts().visits[s]) >= objective_.threshold;
          at(s, index_of(chain_.policy(s))) = seen ? 1 : 0;
        }
        break;
      case ObjectiveKind::collisions:
      case ObjectiveKind::unknown:
        fill_unwanted();
        break;
    }
    agree_where_episodes_end();
    find_best();
    return std::move(table_);
  }

 private:
  std::int64_t& at(std::size_t state, std::size_t action) {
    return table_.scores[state * (chain_.actions() + 1) + action];
  }

  Result<void> fill_shaped() {
    if (auto ok = check_rules(chain_, objective_.rules); !ok) {
      return ok;
    }
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      const auto features = chain_.features_of(s);
      const auto rule =
          std::find_if(objective_.rules.begin(), objective_.rules.end(), [&](const ShapedRule& candidate) {
            return candidate.any_of.empty() ||
                   std::any_of(candidate.any_of.begin(), candidate.any_of.end(),
                               [&](const Node& condition) { return holds(condition, features); });
          });
      if (rule == objective_.rules.end()) {
        continue;
      }
      for (std::size_t a = 0; a <= chain_.actions(); ++a) {
        at(s, a) = a == index_of(chain_.policy(s)) ? rule->right : rule->wrong;
      }
    }
    return {};
  }

  Result<void> fill_values() {
    const auto value_of = [this](std::size_t row) {
      return objective_.kind == ObjectiveKind::q_value ? chain_.parts().q[row] : chain_.mean_reward(row);
    };
    double largest = 0.0;
    for (std::size_t row = 0; row < chain_.states() * chain_.actions(); ++row) {
      const double value = value_of(row);
      if (!(std::abs(value) <= kMaxScoredValue)) {
        return bad_input(
            fmt::format("objective '{}': row {} has value {}: expected within +-{}: divide the rewards of the "
                        "source, and import it again",
                        name_of(objective_.kind), row, value, kMaxScoredValue));
      }
      largest = std::max(largest, std::abs(value));
    }
    table_.unit = unit_for(largest, kFineScoredValue, kScoreOne);
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      for (std::size_t a = 0; a < chain_.actions(); ++a) {
        // Rounded to the nearest, ties away from zero: the same on every machine.
        at(s, a) = std::llround(value_of(s * chain_.actions() + a) * table_.unit);
      }
      give_what_is_taken(s);
    }
    return {};
  }

  Result<void> fill_regret() {
    double visits = 0.0;
    for (const std::uint64_t count : chain_.parts().visits) {
      visits += static_cast<double>(count);
    }
    const std::size_t actions = chain_.actions();
    const auto widest = widest_gap();
    if (!widest) {
      return tl::unexpected(widest.error());
    }
    table_.unit = unit_for(*widest, 2.0 * kFineScoredValue, kRegretOne);
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      const double* q = chain_.parts().q.data() + s * actions;
      const double best = best_q(s);
      const double share = visits > 0.0 ? static_cast<double>(chain_.parts().visits[s]) / visits : 0.0;
      std::int64_t worst = 0;
      for (std::size_t a = 0; a < actions; ++a) {
        if (chain_.is_forbidden(s, a)) {
          continue;
        }
        at(s, a) = std::llround((best - q[a]) * share * table_.unit);
        worst = std::max(worst, at(s, a));
      }
      at(s, actions) = worst;
      give_what_is_taken(s, worst);
    }
    return {};
  }

  // What the policy expects, or what could be had.
  double best_q(std::size_t state) const {
    return std::max(chain_.parts().q[chain_.row(state, chain_.policy(state))], highest_allowed(state));
  }

  // The most that an action can be worse than the best of its state.
  Result<double> widest_gap() const {
    double widest = 0.0;
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      const double best = best_q(s);
      for (std::size_t a = 0; a < chain_.actions(); ++a) {
        const double gap = chain_.is_forbidden(s, a) ? 0.0 : best - chain_.parts().q[s * chain_.actions() + a];
        if (!(gap <= 2.0 * kMaxScoredValue)) {
          return bad_input(fmt::format("objective 'regret': state {} has Q-values {} apart: expected at most {}", s,
                                       gap, 2.0 * kMaxScoredValue));
        }
        widest = std::max(widest, gap);
      }
    }
    return widest;
  }

  // Of the state's actions that are not forbidden.
  double highest_allowed(std::size_t state) const {
    const double* q = chain_.parts().q.data() + state * chain_.actions();
    double highest = -std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < chain_.actions(); ++a) {
      highest = chain_.is_forbidden(state, a) ? highest : std::max(highest, q[a]);
    }
    return highest;
  }

  // No action, or a forbidden one, scores as the action that takes place instead; where the state is held, `held`.
  void give_what_is_taken(std::size_t state, std::int64_t held = 0) {
    for (std::size_t chosen = 0; chosen <= chain_.actions(); ++chosen) {
      const std::size_t taken = chain_.taken(state, chosen);
      if (taken != chosen || taken == chain_.actions()) {
        at(state, chosen) = taken == chain_.actions() ? held : at(state, taken);
      }
    }
  }

  // Nothing is decided there: whatever is chosen scores as the policy's choice.
  void agree_where_episodes_end() {
    for (const std::uint32_t state : chain_.parts().terminals) {
      std::fill_n(&at(state, 0), chain_.actions() + 1, at(state, index_of(chain_.policy(state))));
    }
  }

  // Steps that count once: into a collision, or off the edge of what the chain knows.
  void fill_unwanted() {
    const bool told = objective_.kind == ObjectiveKind::collisions && !chain_.parts().collisions.empty();
    table_.unit = told ? kScoreOne : 1.0;
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      for (std::size_t a = 0; a < chain_.actions(); ++a) {
        const std::size_t row = s * chain_.actions() + a;
        if (told) {
          at(s, a) = std::llround(chain_.collision_share(row) * kScoreOne);
          continue;
        }
        const bool tried = chain_.tries(row) > 0;
        const bool counts = objective_.kind == ObjectiveKind::unknown
                                ? !tried
                                : tried && chain_.mean_reward(row) <= objective_.threshold;
        at(s, a) = counts ? 1 : 0;
      }
      give_what_is_taken(s);
    }
  }

  void find_best() {
    const std::size_t stride = chain_.actions() + 1;
    std::int64_t best = 0;
    for (std::size_t s = 0; s < chain_.states(); ++s) {
      const auto begin = table_.scores.begin() + static_cast<std::ptrdiff_t>(s * stride);
      const std::int64_t best_here = *std::max_element(begin, begin + static_cast<std::ptrdiff_t>(stride));
      best = along_walk(objective_.kind) ? std::max(best, best_here) : best + best_here;
    }
    table_.best_per_step = std::max<std::int64_t>(best, 1);
  }

  const Chain& chain_;
  const Objective& objective_;
  ScoreTable table_;
};

}  // namespace

Result<std::vector<ShapedRule>> thesis_rules(const Vocabulary& vocabulary) {
  constexpr std::uint8_t kWall = 0;
  constexpr std::uint8_t kTrash = 3;
  const auto ahead = vocabulary.find_feature("s3");
  const auto ahead_right = vocabulary.find_feature("s4");
  const auto right = vocabulary.find_feature("s5");
  if (!ahead || !ahead_right || !right) {
    return bad_input(
        "objective 'shaped' without rules needs features s3, s4 and s5, which this chain lacks: give rules");
  }
  const auto is = [](std::size_t feature, std::uint8_t value) { return Node::condition(feature, Op::equal, value); };
  return std::vector<ShapedRule>{{{is(*ahead, kTrash), is(*ahead_right, kTrash), is(*right, kTrash)}, 8, -4},
                                 {{is(*ahead, kWall)}, 1, -2},
                                 {{}, 1, 0}};
}

Result<ScoreTable> make_score_table(const Chain& chain, const Objective& objective) {
  return TableMaker(chain, objective).make();
}

}  // namespace coppice
