// A Markov decision process as a file of another tool describes it: states with what is read in them, actions, and for
// every (state, action) the successors with their probabilities and the expected reward. Names are as the source spells
// them; chains have rules for names, counts and values, which make_chain() (chain_of_model.hpp) brings about.
// A plain value; whoever made it checked it with check_model().
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"

namespace coppice {

inline constexpr std::size_t kMaxModelFeatures = 64;
inline constexpr std::size_t kMaxModelRows = std::size_t{1} << 28U;  // states x actions
inline constexpr double kRowTolerance = 1e-6;                        // by which the probabilities of a row may miss 1

struct ModelStart {
  std::uint32_t state = 0;
  double probability = 0.0;  // > 0
};

struct Model {
  std::vector<std::string> feature_names;
  std::vector<double> readings;  // [states x features], finite
  std::vector<std::string> action_names;
  // Rows are (state, action) pairs: row = state * actions + action. An empty row: the state lacks the action.
  std::vector<std::uint64_t> row_begin;  // [states * actions + 1]
  std::vector<std::uint32_t> successor;  // [transitions], ascending and unique in a row
  std::vector<double> probability;       // [transitions], > 0, a row's sum is 1; empty: `count` is there instead
  std::vector<double> reward;            // [states x actions], expected, of one step; finite; 0 in an empty row
  std::vector<std::uint32_t> count;      // [transitions], of a log: how often, >= 1; solve() takes them as they are
  std::vector<bool> distrusted;          // [states x actions], of a log: what solve() must not take; empty: nothing
  std::vector<double> collision;         // [states x actions], probability; empty: the source does not say
  std::vector<std::uint32_t> terminals;  // ascending: an episode ends on arrival; their rows do not matter
  std::vector<ModelStart> starts;        // ascending by state, the sum is 1
  std::map<std::string, std::vector<std::uint32_t>> labels;  // of the source, ascending states
  std::vector<std::uint32_t> source_state;  // [states], each state's number in the source; empty: the same

  std::size_t states() const { return readings.empty() ? 0 : readings.size() / feature_names.size(); }
  std::size_t actions() const { return action_names.size(); }
  std::size_t rows() const { return row_begin.empty() ? 0 : row_begin.size() - 1; }
  bool is_terminal(std::uint32_t state) const;
  std::uint32_t source_of(std::uint32_t state) const { return source_state.empty() ? state : source_state[state]; }
  std::span<const double> readings_of(std::size_t state) const {
    return std::span<const double>(readings).subspan(state * feature_names.size(), feature_names.size());
  }
};

// What a source holds of a row, in any order and with repeats.
struct ModelTransition {
  std::uint32_t successor = 0;
  double probability = 0.0;
};

// Collects rows as a source gives them and makes the arrays of a Model of them.
class ModelRows {
 public:
  // Sorts, adds repeats up, leaves out what has probability 0, and divides by the sum. Errors: a probability outside
  // [0, 1 + kRowTolerance], a sum further than kRowTolerance from 1, a reward that is not finite, a second row of the
  // same pair.
  Result<void> add(std::uint32_t state, std::uint32_t action, double reward, std::vector<ModelTransition>& row);

  std::size_t transitions() const { return transitions_.size(); }
  // Fills row_begin, successor, probability and reward. Errors: a successor that is not a state, a state or action
  // beyond those given.
  Result<void> fill(std::size_t states, std::size_t actions, Model& model);

 private:
  struct Row {
    std::uint32_t state = 0;
    std::uint32_t action = 0;
    double reward = 0.0;
    std::uint64_t begin = 0;
  };
  std::vector<Row> rows_;
  std::vector<ModelTransition> transitions_;
};

// Errors name what is wrong: no state, action or feature, sizes that disagree, a start or terminal that is no state,
// starts that do not sum to 1, a state without any action that is not terminal is allowed (nothing can be done there).
Result<void> check_model(const Model& model);

// States that no action leaves and where nothing is earned end episodes: adds them to the terminals.
void find_sinks(Model& model);

// Takes out what no episode reaches: a terminal state leads nowhere. Returns how many states went.
std::size_t keep_reachable(Model& model);

// Takes actions out of the model, by name. Errors: no such action; none is left.
Result<void> drop_actions(const std::vector<std::string>& names, Model& model);

}  // namespace coppice
