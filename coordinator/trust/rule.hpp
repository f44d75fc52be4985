// A rule about a tree, in one line, as a designer writes it:
//
//   never move when s3=0
//   always turn_left or turn_right when s3=0 and s1!=3
//   never none                                          (it always chooses an action)
//
//   rule      = ("never" | "always") action { "or" action } [ "when" condition ]
//   action    = an action's name | "none", which is no action at all
//   condition = all { "or" all };  all = test { "and" test }
//   test      = feature ("=" | "!=" | "<=" | "<" | ">=" | ">") value
//
// Without "when" it is about every observation. A plain value.
#pragma once

#include <bitset>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

inline constexpr std::size_t kMaxRuleText = 4096;  // characters

// Which values a feature may have. Bit v: the value v.
using ValueSet = std::bitset<256>;

struct Rule {
  std::string text;  // as given
  bool always = false;
  std::vector<ActionId> actions;            // kNoAction: none
  std::vector<std::vector<ValueSet>> when;  // any of these; [features] the values allowed, none of them empty
  // Whether a tree that does `action` where the rule applies breaks it.
  bool broken_by(ActionId action) const;
  // Whether it applies to an observation. [features]
  bool applies(std::span<const std::uint8_t> features) const;
};

// Errors name the column (from 1), what was found and what was expected: a value that the feature never has, a
// condition that no observation meets. Never throws on any input.
Result<Rule> parse_rule(std::string_view text, const Vocabulary& vocabulary);

// Rules from a file, one a line; blank lines and lines that start with # are skipped. Errors name file and line.
Result<std::vector<Rule>> read_rules(const std::string& path, const Vocabulary& vocabulary);

}  // namespace coppice
