// Writes a model as PRISM's explicit files, which stand beside one another under one stem:
//   STEM.tra  transitions    STEM.sta  the features of every state, and which states are none of the chain's
//   STEM.lab  labels         STEM.gain.EXT, STEM.cost.EXT  rewards; EXT is srew for a Markov chain, trew for an MDP
// Load them with: prism -importmodel STEM.tra,sta,lab -ex (-mdp or -dtmc).
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "coordinator/exchange/markov_model.hpp"

namespace coppice {

enum class PrismFile : std::uint8_t { transitions, states, labels, gain, cost };

struct PrismPart {
  PrismFile file;
  std::string extension;  // behind the stem: ".tra"
};
std::vector<PrismPart> prism_parts(const MarkovModel& model);

void write_prism(const MarkovModel& model, PrismFile file, std::ostream& out);

}  // namespace coppice
