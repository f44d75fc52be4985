// How demes share a run: which individuals are whose, when they meet, and who is given migrants by whom. Pure functions
// of (configuration, deme, epoch): no number of threads or workers is in them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/evolution/config.hpp"

namespace coppice {

// The slots of a generation that are a deme's: ga.population is dealt out evenly, the first demes have one more where
// it does not come out even.
struct DemeShare {
  std::uint32_t first = 0;  // of all slots of the run
  std::uint32_t size = 0;
};
// REQUIRES: check_search(), deme < ga.demes.
DemeShare share_of(const GaConfig& ga, std::uint32_t deme);

// Epoch e is the generations from e x epoch_length() to before epoch_end(); the last one may be shorter. One deme meets
// nobody: its epochs may be of any length and change nothing.
std::uint32_t epoch_length(const GaConfig& ga);
std::uint32_t epochs_of(const GaConfig& ga);
// Generations that are done when the epoch is. REQUIRES: epoch < epochs_of(ga).
std::uint32_t epoch_end(const GaConfig& ga, std::uint32_t epoch);

// Who sends each deme the migrants with which it begins the epoch, [demes]; empty: nobody does. Every deme sends to one
// and is sent by one, never itself.
std::vector<std::uint32_t> senders_of(const EvolveConfig& config, std::uint32_t epoch);

}  // namespace coppice
