#include "coordinator/report/plot.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

#include "common/check.hpp"
#include "coordinator/report/program.hpp"
#include "coordinator/report/whole_file.hpp"

namespace coppice {
namespace {

constexpr int kPanelWidth = 380;
constexpr int kRowHeight = 22;  // of one setting
constexpr int kMargins = 90;    // above and below
constexpr std::size_t kLabelWidth = 7;

// A gnuplot string in single quotes, in which nothing is special but the quote itself (in double quotes, backquotes
// would run a command).
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    result += c == '\'' ? "''" : std::string(1, static_cast<unsigned char>(c) < ' ' ? ' ' : c);
  }
  return result + "'";
}

std::string data_of(const IntervalPlot& plot, const PlotPanel& panel) {
  std::string text;
  for (std::size_t i = 0; i < panel.points.size(); ++i) {
    const PlotPoint& point = panel.points[i];
    // The first setting on top.
    fmt::format_to(std::back_inserter(text), "{} {} {} {}\n", point.value, plot.settings.size() - i, point.low,
                   point.high);
  }
  return text + "e\n";
}

}  // namespace

std::string to_gnuplot(const IntervalPlot& plot) {
  COPPICE_CHECK(!plot.settings.empty() && !plot.panels.empty());
  std::size_t longest = 0;
  for (const std::string& setting : plot.settings) {
    longest = std::max(longest, setting.size());
  }
  const std::size_t rows = plot.settings.size();
  const int width = static_cast<int>(longest * kLabelWidth) + kPanelWidth * static_cast<int>(plot.panels.size());
  const double left = static_cast<double>(longest * kLabelWidth + 20) / width;
  const double each = (0.98 - left) / static_cast<double>(plot.panels.size());
  std::string text = fmt::format(
      "set terminal svg size {},{} noenhanced font 'Helvetica,12' background rgb 'white'\n"
      "set multiplot title {}\n"
      "set key off\nset grid xtics\nset yrange [0.5:{}.5]\nset tmargin 4\nset bmargin 3\nset ytics ()\n",
      width, kMargins + kRowHeight * static_cast<int>(rows), quoted(plot.title), rows);
  for (std::size_t p = 0; p < plot.panels.size(); ++p) {
    const double from = left + static_cast<double>(p) * each;
    fmt::format_to(std::back_inserter(text), "set lmargin at screen {:.4f}\nset rmargin at screen {:.4f}\n", from,
                   from + each * 0.88);
    std::string tics;
    for (std::size_t i = 0; i < rows; ++i) {
      fmt::format_to(std::back_inserter(tics), "{}{} {}", i == 0 ? "" : ", ",
                     quoted(p == 0 ? plot.settings[i] : std::string()), rows - i);
    }
    fmt::format_to(std::back_inserter(text), "set ytics ({})\nset title {}\n", tics, quoted(plot.panels[p].title));
    fmt::format_to(std::back_inserter(text),
                   "plot '-' using 1:2:3:4 with xerrorbars pointtype 7 pointsize 0.6 linecolor rgb '#1f5fa8'\n{}",
                   data_of(plot, plot.panels[p]));
  }
  return text + "unset multiplot\n";
}

Result<void> check_gnuplot() {
  return has_program("gnuplot") ? Result<void>() : failed("the program 'gnuplot' is not on PATH: install gnuplot-nox");
}

Result<void> write_plot(const IntervalPlot& plot, const std::filesystem::path& path) {
  if (auto found = check_gnuplot(); !found) {
    return found;
  }
  const std::string body = to_gnuplot(plot);
  return produce_whole_file(path, [&](const std::filesystem::path& temporary) {
    return run_program({"gnuplot"}, fmt::format("set output {}\n{}", quoted(temporary.string()), body));
  });
}

}  // namespace coppice
