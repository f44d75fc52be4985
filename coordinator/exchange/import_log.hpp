// A log of transitions turned into a chain: passes over the file to find actions and bins, one that counts
// (log_passes.hpp), and a policy: solved, given, or what the log shows (log_policy.hpp).
#pragma once

#include "common/error.hpp"
#include "coordinator/exchange/import_source.hpp"

namespace coppice {

// Without --solve, --q and --policy the policy is what the log does most in each state, ties to the lowest index.
// Errors: as import_source(). REQUIRES: format is csv_log or json_log.
Result<Imported> import_log(const ImportSettings& settings, SourceFormat format, const ImportProgress& go_on);

}  // namespace coppice
