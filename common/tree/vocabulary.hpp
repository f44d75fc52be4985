// What a tree may talk about: the features that it can test, with their values and operators, and the actions
// that it can choose. A chain declares its vocabulary; every tree belongs to one. Immutable after
// check_vocabulary(); safe to share between threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"

namespace coppice {

enum class Op : std::uint8_t { equal = 0, less_equal = 1 };

// An action's index in Vocabulary::actions. kNoAction is what a tick gives when nothing was written.
enum class ActionId : std::uint8_t {};
inline constexpr ActionId kNoAction{0xFF};

constexpr std::size_t index_of(ActionId action) { return static_cast<std::size_t>(action); }

inline constexpr std::size_t kMaxFeatures = 64;
inline constexpr std::size_t kMaxActions = 254;  // an action's code is a byte, and kNoAction is one
inline constexpr std::size_t kMaxValues = 255;   // of one feature
inline constexpr std::size_t kMaxNameLength = 64;

// What the values of a feature stand for. A value is a small code wherever trees are evaluated; where people write and
// read it, it is a number of the feature's own unit.
enum class Scale : std::uint8_t {
  plain = 0,    // the value itself
  numbers = 1,  // value i is the number numbers[i]
  bins = 2,     // value i is every reading r with numbers[i - 1] < r <= numbers[i]; the first bin has no lower end, the
                // last no upper one. "name<=edge" is then exact for readings, too
};

struct Feature {
  std::string name;                  // [A-Za-z_][A-Za-z0-9_]*
  std::vector<std::uint8_t> values;  // what it can read, ascending, at least one
  bool admits_equal = true;          // conditions "name=value"; never with bins
  bool admits_less_equal = false;    // conditions "name<=value"
  Scale scale = Scale::plain;
  // Strictly ascending, finite. plain: empty; numbers: one for each value; bins: the edges, one fewer than values.
  std::vector<double> numbers = {};

  bool admits(Op op) const { return op == Op::equal ? admits_equal : admits_less_equal; }
  // The value that a reading in the feature's own unit has. None: it is not one that the feature can read (or not a
  // number). Every number has a bin.
  std::optional<std::uint8_t> value_of(double reading) const;
  // As a condition writes it: "3", "-0.25"; "inf" for the last bin. REQUIRES: one of `values`.
  std::string number_text(std::uint8_t value) const;
  // What a state reads: "s3=0", "x=-7", "pole_angle in (-0.1, 0.0419]". REQUIRES: one of `values`.
  std::string reading_text(std::uint8_t value) const;
  // The inverse of number_text(); other spellings of a number are accepted ("0.50"). None: no such value.
  std::optional<std::uint8_t> value_of_text(std::string_view text) const;
  // All of them as conditions write them, for messages: "0, 1, 3". A long list is cut short.
  std::string values_text() const;
  bool operator==(const Feature&) const = default;
};

struct Vocabulary {
  std::vector<Feature> features;
  std::vector<std::string> actions;

  std::optional<std::size_t> find_feature(std::string_view name) const;
  std::optional<ActionId> find_action(std::string_view name) const;
  bool operator==(const Vocabulary&) const = default;
};

// Errors: no feature or action, too many, a name that is malformed, repeated or reserved ("sequence",
// "selector"), values empty, too many or not ascending, a feature that admits no operator, or = on bins, numbers that
// do not fit scale and values.
Result<void> check_vocabulary(const Vocabulary& vocabulary);

}  // namespace coppice
