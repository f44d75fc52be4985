// What a user says about the problem that is imported, beyond what its source holds: a TOML file, or what a source of
// ours (P tables, logs) says in its header. See coordinator/exchange/README.md for the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"

namespace coppice {

// How a feature's readings become values.
struct Binning {
  enum class Kind : std::uint8_t { none = 0, edges = 1, quantiles = 2, entropy = 3 };
  Kind kind = Kind::none;
  std::vector<double> edges;  // edges only
  std::size_t bins = 0;       // quantiles, entropy: at most so many
};

struct FeatureWish {
  std::string name = {};  // to be called by; empty: as the source does
  std::string label = {};
  std::string unit = {};
  std::map<double, std::string> values = {};  // labels of readings
  std::optional<Binning> binning = {};
  std::optional<bool> admits_equal = {};
  std::optional<bool> admits_less_equal = {};
};

struct ActionWish {
  std::string name;
  std::string label;
};

enum class WhenTerminal : std::uint8_t { absorb = 0, again = 1 };
enum class LookAlikes : std::uint8_t { apart = 0, merge = 1 };

// States by what they read, by a label of the source, or by their number.
struct StateChoice {
  std::string when;   // a predicate; empty: none
  std::string label;  // empty: none
  std::map<std::uint32_t, double> shares;
  bool empty() const { return when.empty() && label.empty() && shares.empty(); }
};

struct ProblemFile {
  std::string title;
  std::string simulator;
  std::string reward;  // which of the source's rewards
  std::optional<double> discount;
  std::string no_action = "worst";  // "hold", "worst", or an action of the source
  WhenTerminal terminal = WhenTerminal::absorb;
  LookAlikes look_alikes = LookAlikes::apart;
  std::vector<std::string> without_actions;
  std::map<std::string, FeatureWish> features;  // by the source's name
  std::map<std::string, ActionWish> actions;    // by the source's name
  std::optional<double> collision_reward;       // a step with this reward or less is a collision
  StateChoice collisions;                       // a step that arrives there is one
  StateChoice terminals;                        // besides those of the source
  StateChoice initial;                          // instead of the source's
};

// Errors name file, line and key, what was found and what was expected. Unknown keys are refused, with the known ones.
Result<ProblemFile> read_problem_file(const std::string& path);

}  // namespace coppice
