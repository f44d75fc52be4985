// Progress of one long task on standard error: one line that is redrawn on a terminal, plain lines elsewhere. Never
// touches standard output. Used by one thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace coppice {

using Clock = std::chrono::steady_clock;

struct ProgressSettings {
  bool redraw = false;                          // one line, redrawn; else plain lines
  std::size_t columns = 80;                     // of the terminal; a redrawn line never wraps
  std::chrono::milliseconds redraw_every{100};  // at most this often
  std::chrono::milliseconds plain_every{5000};  // plain: a line when this much time has passed; 0: never
  std::uint64_t plain_every_done = 0;           // plain: a line at each multiple of this many done; 0: never
};

// redraw and columns as the terminal behind `out` has them.
ProgressSettings progress_settings_for(std::FILE* out);

struct ProgressAt {
  std::string_view label;
  std::string_view unit;    // "generations"; may be empty
  std::uint64_t begin = 0;  // done before this process started (a resumed run); counts for the bar, not for the rate
  std::uint64_t done = 0;
  std::uint64_t total = 0;  // 0: not known
  std::chrono::duration<double> elapsed{0};
  std::string_view extra;  // free text behind the figures
};

// "evolve [######......] 120/400 generations, 45.2/s, 6 s left, best 0.93": with a bar, cut to `columns`.
std::string redrawn_line(const ProgressAt& at, std::size_t columns);
// "evolve: 120/400 generations, 45.2/s, 6 s left, best 0.93".
std::string plain_line(const ProgressAt& at);

class Progress {
 public:
  // `out` outlives this. Text is made printable before it is shown.
  Progress(std::FILE* out, const ProgressSettings& settings, const std::string& label, const std::string& unit,
           std::uint64_t total, std::uint64_t begin = 0, Clock::time_point now = Clock::now());
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();  // leaves the cursor at the start of an empty line

  // Shows the new figures if it is time to.
  void update(std::uint64_t done, std::string_view extra = {}, Clock::time_point now = Clock::now());
  // Shows the figures now and ends the line. update() must not follow.
  void finish(std::uint64_t done, std::string_view extra = {}, Clock::time_point now = Clock::now());
  // A line of its own, above the redrawn one.
  void say(std::string_view line);

 private:
  ProgressAt at(std::uint64_t done, std::string_view extra, Clock::time_point now) const;
  void clear();

  std::FILE* out_;
  ProgressSettings settings_;
  std::string label_;
  std::string unit_;
  std::uint64_t total_;
  std::uint64_t begin_;
  Clock::time_point started_;
  Clock::time_point shown_;
  std::uint64_t shown_done_;
  std::string drawn_;  // what the terminal's last line shows now
};

}  // namespace coppice
