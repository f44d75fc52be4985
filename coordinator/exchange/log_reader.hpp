// A log of transitions, step by step, in constant memory: CSV with a header, or JSON lines. Owns the open file.
//
//   CSV     [episode,] [step,] FEATURE..., action, reward [, next_FEATURE...] [, terminated] [, truncated]; every
//   column that
//           is none of these is a feature
//   JSON    a first line {"format": "coppice-log-1", ...} (source_header.hpp) if there is one; then
//           {"episode", "step", "observation": [...] or {FEATURE: ...}, "action", "reward", "next_observation",
//           "terminated", "truncated"}
//
// Booleans are true/false or 0/1. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "coordinator/exchange/line_reader.hpp"
#include "coordinator/exchange/source_header.hpp"

namespace coppice {

// One line. Spans and texts hold until the next one is read.
struct LogStep {
  std::string_view episode;             // as written; empty: the log has no episodes
  std::optional<std::uint64_t> step;    // within its episode
  std::span<const double> observation;  // [features], finite
  std::string_view action;              // a name or a number, as written
  double reward = 0.0;                  // finite
  std::span<const double> next;         // [features], or empty: the next line has it
  bool terminated = false;
  bool truncated = false;
};

class LogReader {
 public:
  virtual ~LogReader() = default;
  // False: the end. Errors name file, line and column or member, what was found and what was expected.
  virtual Result<bool> next(LogStep& step) = 0;
  virtual const LineReader& lines() const = 0;
  // REQUIRES: next() was called once, for a log of JSON lines; a log with a header line has them at once.
  virtual const SourceHeader& header() const = 0;
  virtual const std::vector<std::string>& features() const = 0;
};

Result<std::unique_ptr<LogReader>> open_csv_log(const std::string& path);
Result<std::unique_ptr<LogReader>> open_json_log(const std::string& path);

}  // namespace coppice
