// A chain as a model checker sees it: the MDP that was counted, or the Markov chain that a tree makes of it; with exact
// rows, and intervals for what the counts leave open. What the writers of DRN and PRISM files share; nothing is copied,
// so a chain of millions of states is written as it is read. Const members are safe from any thread.
//
// States are the chain's, by their numbers; then one absorbing state `unknown`; then, where episodes start in one of
// several states, a state `start` that leads there without reward, so that everything happens one step later.
//  * MDP: a choice for every action that was tried; a state in which none was has one choice, to `unknown`. A state
//  that
//    ends episodes has one.
//  * Under a tree: what takes place there (Chain::taken). Where nothing takes place the state is held, without reward.
//  An
//    action that was never tried leads to `unknown`: the probability of ever coming there is that of leaving the model.
// Rewards are the mean rewards that were recorded, split in `gain` and `cost`, both >= 0: a signed reward has been seen
// to give a wrong result without a word.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// A property of states that the file names: "collision". [states of the chain]
struct StateLabel {
  std::string name;
  std::vector<bool> holds;
};

struct ModelTarget {
  std::uint32_t state = 0;
  double probability = 0.0;
  double low = 0.0;  // 95 %, Wilson's score interval for the counts; exact rows: the probability
  double high = 0.0;
};

struct ModelChoice {
  std::string_view action;           // holds as long as the model
  std::vector<ModelTarget> targets;  // ascending; their probabilities sum to 1 in double arithmetic, in this order
  double gain = 0.0;
  double cost = 0.0;
};

class MarkovModel {
 public:
  // `chain` and `tree` outlive this. Without a tree: the MDP. REQUIRES: check_tree(); labels have an entry for each
  // state and are named neither "init" nor "deadlock", "terminal", "unknown" or "start".
  MarkovModel(const Chain& chain, const Tree* tree, std::vector<StateLabel> labels);

  bool is_mdp() const { return actions_.empty(); }
  const Chain& chain() const { return chain_; }
  std::size_t states() const { return unknown_ + (start_ ? 2U : 1U); }
  std::uint64_t choices() const { return choices_; }
  std::uint64_t transitions() const { return transitions_; }
  std::uint32_t initial() const { return start_.value_or(chain_.initial_state()); }
  // "init" first, then the other labels that a state can have.
  const std::vector<std::string>& label_names() const { return label_names_; }
  // Indices into label_names(), ascending.
  std::vector<std::size_t> labels_of(std::size_t state) const;
  // Overwrites `choices`, keeping its memory.
  void choices_of(std::size_t state, std::vector<ModelChoice>& choices) const;

 private:
  void add_row(std::size_t row, std::string_view action, std::vector<ModelChoice>& choices, std::size_t& used) const;

  const Chain& chain_;
  std::vector<std::uint8_t> actions_;  // [states] what takes place under the tree; the number of actions: hold
  std::uint32_t unknown_;
  std::optional<std::uint32_t> start_;
  std::vector<StateLabel> labels_;
  std::vector<std::string> label_names_;
  std::uint64_t choices_ = 0;
  std::uint64_t transitions_ = 0;
};

}  // namespace coppice
