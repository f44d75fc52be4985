// The passes over a log: which actions and readings it has, where bins are cut, and one that counts. Each pass reads
// the file from its start, so memory grows with the states and transitions, not with the log.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "coordinator/exchange/import_source.hpp"
#include "coordinator/exchange/log_counter.hpp"
#include "coordinator/exchange/source_header.hpp"

namespace coppice {

inline constexpr std::size_t kLogSample = 100'000;  // steps that bins are made from
inline constexpr std::size_t kDefaultBins = 8;      // of a feature that has too many readings
inline constexpr std::size_t kFewReadings = 32;     // distinct readings that are fractions, beyond which there are bins
inline constexpr std::size_t kMaxPasses = 600;      // over the file

struct CountedLog {
  std::unique_ptr<LogCounter> counter;  // finished
  SourceHeader header;                  // features always named
  std::vector<std::string> actions;     // by index: as the header names them, else as written
};

// What the log's own header says is added to `file`, where that says nothing. Errors name file and line, or the key of
// the problem file; interrupted. REQUIRES: format is csv_log or json_log.
Result<CountedLog> count_log(const ImportSettings& settings, SourceFormat format, ProblemFile& file,
                             const ImportProgress& go_on);

}  // namespace coppice
