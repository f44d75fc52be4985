#include "coordinator/report/interval_plot.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

#include "common/check.hpp"
#include "coordinator/report/gnuplot.hpp"

namespace coppice {
namespace {

constexpr int kPanelWidth = 380;
constexpr int kRowHeight = 22;  // of one setting
constexpr int kMargins = 90;    // above and below
constexpr std::size_t kLabelWidth = 7;

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
  std::string text = gnuplot_terminal(width, kMargins + kRowHeight * static_cast<int>(rows));
  text += fmt::format(
      "set multiplot title {}\n"
      "set key off\nset grid xtics\nset yrange [0.5:{}.5]\nset tmargin 4\nset bmargin 3\nset ytics ()\n",
      gnuplot_string(plot.title), rows);
  for (std::size_t p = 0; p < plot.panels.size(); ++p) {
    const double from = left + static_cast<double>(p) * each;
    fmt::format_to(std::back_inserter(text), "set lmargin at screen {:.4f}\nset rmargin at screen {:.4f}\n", from,
                   from + each * 0.88);
    std::string tics;
    for (std::size_t i = 0; i < rows; ++i) {
      fmt::format_to(std::back_inserter(tics), "{}{} {}", i == 0 ? "" : ", ",
                     gnuplot_string(p == 0 ? plot.settings[i] : std::string()), rows - i);
    }
    fmt::format_to(std::back_inserter(text), "set ytics ({})\nset title {}\n", tics,
                   gnuplot_string(plot.panels[p].title));
    fmt::format_to(std::back_inserter(text),
                   "plot '-' using 1:2:3:4 with xerrorbars pointtype 7 pointsize 0.6 linecolor rgb '#1f5fa8'\n{}",
                   data_of(plot, plot.panels[p]));
  }
  return text + "unset multiplot\n";
}

Result<void> write_plot(const IntervalPlot& plot, const std::filesystem::path& path) {
  return draw_by_gnuplot(to_gnuplot(plot), path);
}

}  // namespace coppice
