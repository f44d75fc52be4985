// A test of what is read in a state, as a problem file writes it: `x<=0.5 and y=3 or crashed!=0`. "and" binds closer
// than "or"; operators = != < <= > >=; features by the names of the source, numbers in the feature's own unit. A plain
// value.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"

namespace coppice {

inline constexpr std::size_t kMaxPredicate = 4096;  // characters

class Predicate {
 public:
  // Errors name the column, what was found and what was expected, with the features that exist.
  static Result<Predicate> parse(std::string_view text, const std::vector<std::string>& features);

  // readings: [features]
  bool holds(std::span<const double> readings) const;

 private:
  enum class Op { equal, unequal, less, less_equal, greater, greater_equal };
  struct Test {
    std::size_t feature = 0;
    Op op = Op::equal;
    double number = 0.0;
  };
  static bool compares(double reading, const Test& test);

  std::vector<std::vector<Test>> any_of_;  // each all of its tests
};

}  // namespace coppice
