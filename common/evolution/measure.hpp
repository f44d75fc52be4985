// What a tree is measured by, in the units that a user reads: the objectives, and its size. Front searches compare
// trees by measures, rules pick by them, studies keep them. A measure is a pure function of a
// tree and its tally.
//
//   agreement, coverage, visits, seen     shares in [0, 1]
//   return                                reward a walk of rollout.steps steps             [reward]
//   collisions, unknown                   such steps a walk                                [steps]
//   q_value, shaped                       mean a step
//   regret                                mean over the visits counted in learning         [unit of Q]
//   nodes, conditions                     of the tree
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/fitness/job.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// The objectives by their own numbers, then what is no objective of a job.
enum class Measure : std::uint8_t {};
inline constexpr Measure kNodesMeasure{kObjectiveKinds};
inline constexpr Measure kConditionsMeasure{kObjectiveKinds + 1};
inline constexpr std::uint8_t kMeasures = kObjectiveKinds + 2;

constexpr Measure measure_of(ObjectiveKind kind) { return Measure{static_cast<std::uint8_t>(kind)}; }
constexpr bool is_objective(Measure measure) { return static_cast<std::uint8_t>(measure) < kObjectiveKinds; }
// REQUIRES: is_objective(measure).
constexpr ObjectiveKind kind_of(Measure measure) { return ObjectiveKind{static_cast<std::uint8_t>(measure)}; }
constexpr bool is_cost(Measure measure) { return !is_objective(measure) || is_cost(kind_of(measure)); }

std::string_view name_of(Measure measure);
// Errors list the names that exist.
Result<Measure> measure_named(std::string_view name);

// "agreement, coverage, nodes": distinct measures, at least one. Errors name what was found and what was expected.
Result<std::vector<Measure>> measures_from(std::string_view text);
std::string to_text(std::span<const Measure> measures);

class Measuring {
 public:
  // Measures everything that a job with these objectives gives, in the order of Measure, the sizes last.
  // REQUIRES: objectives of distinct kinds, in the order of ObjectiveKind. Errors: as make_score_table().
  static Result<Measuring> make(const Chain& chain, const std::vector<Objective>& objectives, std::uint32_t steps);

  const std::vector<Measure>& measures() const { return measures_; }
  // [measures] REQUIRES: tally.scores has one entry per objective; tally.steps > 0.
  std::vector<double> values(const Tree& tree, const Tally& tally) const;

  // What a measure grows by for 1 more in the mean score a step, or, over states, in the score. REQUIRES: of an
  // objective, by index into measures().
  double slope(std::size_t objective) const;

 private:
  std::vector<Measure> measures_;
  std::vector<double> scale_;  // [objectives], value = score x scale, for a walk's objective a step
  double steps_ = 1.0;
};

}  // namespace coppice
