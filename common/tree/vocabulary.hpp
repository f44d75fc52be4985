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
inline constexpr std::size_t kMaxActions = 64;
inline constexpr std::size_t kMaxNameLength = 64;

struct Feature {
  std::string name;                  // [A-Za-z_][A-Za-z0-9_]*
  std::vector<std::uint8_t> values;  // what it can read, ascending, at least one
  bool admits_equal = true;          // conditions "name=value"
  bool admits_less_equal = false;    // conditions "name<=value"

  bool admits(Op op) const { return op == Op::equal ? admits_equal : admits_less_equal; }
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
// "selector"), values empty or not ascending, a feature that admits no operator.
Result<void> check_vocabulary(const Vocabulary& vocabulary);

}  // namespace coppice
