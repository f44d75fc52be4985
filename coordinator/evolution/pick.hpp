// Which tree of a front is the one: a rule in words.
//
//   best return with nodes<=20 and coverage>=0.8 and collisions=0
//   best return with collisions<=0 else best agreement
//   best fitness
//
// rule = choice {"else" choice}, of which the first that a tree fits chooses;
// choice = "best" measure ["with" condition {"and" condition}]; condition = measure ("<=" | ">=" | "=") number; a
// measure is one of Measure, or fitness. The best is the largest value, of costs the smallest; ties: higher fitness,
// fewer nodes, then earlier. A measure that a front does not have fits no condition.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/evolution/measure.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// One tree of a front, as it was measured.
struct FrontMember {
  Tree tree{ActionId{0}};
  double fitness = 0.0;        // scalar
  std::vector<double> values;  // [measures of the front]
  bool operator==(const FrontMember&) const = default;
};

struct Front {
  std::vector<Measure> measures;
  std::vector<FrontMember> members;
  bool operator==(const Front&) const = default;
};

enum class Relation : std::uint8_t { at_most, at_least, equal };

struct PickCondition {
  std::optional<Measure> measure;  // none: fitness
  Relation comparison = Relation::at_most;
  double number = 0.0;
};

struct PickRule {
  std::optional<Measure> best;  // none: fitness
  std::vector<PickCondition> conditions;
  std::vector<PickRule> otherwise = {};  // in turn, where no member fits
};

// Errors name the word found and what was expected.
Result<PickRule> parse_pick(std::string_view text);

// The index of a member; none: no member fits.
std::optional<std::size_t> pick(const Front& front, const PickRule& rule);

// Of one member; none: the front does not have the measure.
std::optional<double> value_of(const Front& front, const FrontMember& member, std::optional<Measure> measure);

}  // namespace coppice
