#include "coordinator/console/progress.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <sys/ioctl.h>
#include <unistd.h>
#include <utility>

#include "coordinator/console/best_effort.hpp"
#include "coordinator/console/printable.hpp"

namespace coppice {
namespace {

constexpr std::size_t kBarColumns = 20;
constexpr std::size_t kFewestColumns = 20;

std::string duration_text(double seconds) {
  const auto whole = static_cast<std::uint64_t>(std::llround(seconds));
  if (whole < 60) {
    return fmt::format("{} s", whole);
  }
  if (whole < 3600) {
    return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  }
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string rate_text(double rate) {
  if (rate >= 1e6) {
    return fmt::format("{:.1f}M/s", rate / 1e6);
  }
  if (rate >= 1e4) {
    return fmt::format("{:.1f}k/s", rate / 1e3);
  }
  return fmt::format("{:.1f}/s", rate);
}

std::string figures(const ProgressAt& at) {
  std::string text = at.total > 0 ? fmt::format("{}/{}", at.done, at.total) : fmt::format("{}", at.done);
  if (!at.unit.empty()) {
    text += fmt::format(" {}", at.unit);
  }
  const double seconds = at.elapsed.count();
  const std::uint64_t here = at.done - std::min(at.begin, at.done);
  if (here > 0 && seconds > 0.0) {
    const double rate = static_cast<double>(here) / seconds;
    text += fmt::format(", {}", rate_text(rate));
    if (at.total > at.done) {
      text += fmt::format(", {} left", duration_text(static_cast<double>(at.total - at.done) / rate));
    }
  }
  if (!at.extra.empty()) {
    text += fmt::format(", {}", at.extra);
  }
  return text;
}

}  // namespace

ProgressSettings progress_settings_for(std::FILE* out) {
  ProgressSettings settings;
  const int file = fileno(out);
  settings.redraw = file >= 0 && isatty(file) == 1;
  winsize size{};
  if (settings.redraw && ioctl(file, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) {
    settings.columns = size.ws_col;
  }
  return settings;
}

std::string redrawn_line(const ProgressAt& at, std::size_t columns) {
  std::string line(at.label);
  if (at.total > 0) {
    const std::uint64_t done = std::min(at.done, at.total);
    const auto filled =
        static_cast<std::size_t>(static_cast<double>(done) / static_cast<double>(at.total) * double{kBarColumns});
    line += fmt::format(" [{}{}]", std::string(filled, '#'), std::string(kBarColumns - filled, '.'));
  }
  line += fmt::format(" {}", figures(at));
  // The last column stays empty: many terminals wrap when it is written.
  const std::size_t limit = std::max(columns, kFewestColumns) - 1;
  if (line.size() > limit) {
    line.resize(limit);
  }
  return line;
}

std::string plain_line(const ProgressAt& at) { return fmt::format("{}: {}", at.label, figures(at)); }

Progress::Progress(std::FILE* out, const ProgressSettings& settings, const std::string& label, const std::string& unit,
                   std::uint64_t total, std::uint64_t begin, Clock::time_point now)
    : out_(out),
      settings_(settings),
      label_(printable(label)),
      unit_(printable(unit)),
      total_(total),
      begin_(begin),
      started_(now),
      shown_(now),
      shown_done_(begin) {}

Progress::~Progress() { clear(); }

ProgressAt Progress::at(std::uint64_t done, std::string_view extra, Clock::time_point now) const {
  return {.label = label_,
          .unit = unit_,
          .begin = begin_,
          .done = done,
          .total = total_,
          .elapsed = now - started_,
          .extra = extra};
}

void Progress::update(std::uint64_t done, std::string_view extra, Clock::time_point now) {
  const auto since = now - shown_;
  if (settings_.redraw) {
    if (!drawn_.empty() && since < settings_.redraw_every) {
      return;
    }
    const std::string shown = printable(extra);
    std::string line = redrawn_line(at(done, shown, now), settings_.columns);
    // Blanks over what the last line had more; no escape sequence, so that any terminal will do.
    const std::size_t longer = drawn_.size() > line.size() ? drawn_.size() - line.size() : 0;
    show(out_, fmt::format("\r{}{}", line, std::string(longer, ' ')));
    drawn_ = std::move(line);
    shown_ = now;
    return;
  }
  const std::uint64_t step = settings_.plain_every_done;
  const bool passed_multiple = step > 0 && done / step > shown_done_ / step;
  const bool time_passed = settings_.plain_every.count() > 0 && since >= settings_.plain_every;
  if (passed_multiple || time_passed) {
    show(out_, plain_line(at(done, printable(extra), now)) + "\n");
    shown_ = now;
    shown_done_ = done;
  }
}

void Progress::finish(std::uint64_t done, std::string_view extra, Clock::time_point now) {
  clear();
  show(out_, plain_line(at(done, printable(extra), now)) + "\n");
}

void Progress::say(std::string_view line) {
  const std::string below = drawn_;
  clear();
  show(out_, fmt::format("{}\n{}", printable(line), below));
  drawn_ = below;
}

void Progress::clear() {
  if (!drawn_.empty()) {
    show(out_, fmt::format("\r{}\r", std::string(drawn_.size(), ' ')));
    drawn_.clear();
  }
}

}  // namespace coppice
