// What a chain is about, for people and for programs around the evaluation: names and units that a person reads, where
// the chain came from, the discount it was solved with, the program that simulates the problem. Nothing here changes a
// figure; what does is in the chain (common/chain/chain.hpp), and the names that trees are written with are in its
// vocabulary. A plain value, kept in a study as one JSON object.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/tree/node.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice {

inline constexpr std::size_t kMaxLabel = 256;              // characters of a label or unit
inline constexpr std::size_t kMaxSimulatorCommand = 4096;  // characters
inline constexpr std::size_t kMaxRules = 50;
inline constexpr std::size_t kMaxRule = 1000;  // characters

struct FeatureLegend {
  std::string label;                           // "ahead"; empty: none, as everywhere below
  std::string unit;                            // "rad"
  std::map<std::uint8_t, std::string> values;  // of some values, by their code: {0, "wall"}
  bool operator==(const FeatureLegend&) const = default;
};

struct Problem {
  std::string title;
  std::string source;                      // in words: the files and the format that it was imported from
  std::vector<FeatureLegend> features;     // [features of the vocabulary]
  std::vector<std::string> action_labels;  // [actions of the vocabulary]
  std::optional<double> discount;          // that Q and policy were solved or learned with, in [0, 1]
  std::string simulator;                   // a shell command that speaks the simulator protocol
  std::vector<std::string> rules =
      {};  // that a tree is to keep to, as a person typed them (coordinator/trust/rule.hpp)
  bool operator==(const Problem&) const = default;
};

// Without any label.
Problem unlabelled(const Vocabulary& vocabulary);

// REQUIRES (all): problem was made for the vocabulary.
std::string to_json(const Problem& problem, const Vocabulary& vocabulary);
// Unknown keys are passed over, so that an older program reads what a newer one wrote. Errors name the key, what was
// found and what was expected: not an object, a label of a feature, value or action that does not exist, texts that are
// too long, a discount outside [0, 1], too many rules.
Result<Problem> problem_from_json(std::string_view text, const Vocabulary& vocabulary);

// What a condition or action says in words, from the labels: "ahead is wall", "pole angle <= 0.0419 rad", "turn left".
// Empty: no label says more than the text form does. Composites: empty.
std::string in_words(const Node& node, const Problem& problem, const Vocabulary& vocabulary);

}  // namespace coppice
