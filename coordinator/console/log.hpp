// Where the program's log goes: standard error, printable, a line each as "coppice: ...", and never more than a
// terminal can bear: what comes faster is counted and reported in one line.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <spdlog/common.h>

namespace coppice {

// Decides which lines of a flood are shown: at most `lines` in each `window`. Used by one thread at a time.
class LineBudget {
 public:
  using Time = std::chrono::system_clock::time_point;

  LineBudget(std::uint32_t lines, std::chrono::milliseconds window) : lines_(lines), window_(window) {}

  struct Verdict {
    bool shown = false;
    std::uint64_t left_out = 0;  // lines of earlier windows that were not shown; to be reported before this one
  };
  Verdict next(Time now);

 private:
  std::uint32_t lines_;
  std::chrono::milliseconds window_;
  Time window_begin_{};
  std::uint32_t used_ = 0;
  std::uint64_t left_out_ = 0;
};

enum class LogFormat : std::uint8_t {
  text,  // "coppice: ..."
  json,  // common/json_log.hpp
};

// Makes the default logger of spdlog, safe from any thread. On a terminal a redrawn progress line is cleared first.
void log_to(std::FILE* out, spdlog::level::level_enum level, LogFormat format = LogFormat::text);

}  // namespace coppice
