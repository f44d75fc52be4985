// Epochs on the small chain of words.hpp, for the fuzz targets of their codec and the corpus that is made for them:
// small runs of both kinds of search, a deme of each that begins, and one that goes on. Written by hand rather than
// bred, so that a change of the search leaves the corpus as it is.
#pragma once

#include <cstddef>
#include <memory>

#include "common/chain/chain.hpp"
#include "common/evolution/epoch.hpp"

namespace coppice::fuzz {

struct SampleEpoch {
  std::shared_ptr<const EvolveConfig> config;
  EpochTask task;
  EpochResult result;  // one that the task may have
};

inline constexpr std::size_t kSampleEpochs = 4;

// REQUIRES: which < kSampleEpochs.
SampleEpoch sample_epoch(std::size_t which, const Chain& chain);

}  // namespace coppice::fuzz
