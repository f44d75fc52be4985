// A log of transitions turned into a chain: passes over the file to find actions and bins, one that counts, and a
// policy: solved, given, or what the log shows.
#pragma once

#include "common/error.hpp"
#include "coordinator/exchange/chain_of_model.hpp"
#include "coordinator/exchange/import_source.hpp"

namespace coppice {

inline constexpr std::size_t kLogSample = 100'000;  // steps that bins are made from
inline constexpr std::size_t kDefaultBins = 8;      // of a feature that has too many readings
inline constexpr std::size_t kFewReadings = 32;     // distinct readings that are fractions, beyond which there are bins
inline constexpr std::size_t kMaxPasses = 600;      // over the file

// Without --solve, --q and --policy the policy is what the log does most in each state, ties to the lowest index.
// Errors: as import_source(). REQUIRES: format is csv_log or json_log.
Result<Imported> import_log(const ImportSettings& settings, SourceFormat format, const ImportProgress& go_on);

}  // namespace coppice
