#include "coordinator/report/interval_plot.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/check.hpp"
#include "coordinator/report/gnuplot.hpp"

namespace coppice {
namespace {

constexpr std::size_t kPanelsAcross = 3;  // what a screen shows side by side
// Pixels:
constexpr double kPanelWidth = 330.0;
constexpr double kBesidePanel = 30.0;  // of that, free
constexpr double kRowHeight = 22.0;    // of one setting
constexpr double kAbovePanel = 36.0;   // for its title
constexpr double kBelowPanel = 34.0;   // for its scale
constexpr double kTitle = 34.0;
constexpr double kLeftMargin = 20.0;
constexpr std::size_t kLabelWidth = 7;  // of a letter

std::string data_of(const IntervalPlot& plot, const PlotPanel& panel) {
  std::string text;
  for (std::size_t i = 0; i < panel.points.size(); ++i) {
    const PlotPoint& point = panel.points[i];
    // The first setting on top.
    text += fmt::format("{} {} {} {}\n", point.value, plot.settings.size() - i, point.low, point.high);
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
  const std::size_t across = std::min(plot.panels.size(), kPanelsAcross);
  const std::size_t down = (plot.panels.size() + across - 1) / across;
  const double labels = static_cast<double>(longest * kLabelWidth) + kLeftMargin;  // pixels, as all that follows
  const double panel_height = static_cast<double>(rows) * kRowHeight;
  const double line_height = panel_height + kAbovePanel + kBelowPanel;
  const double width = labels + static_cast<double>(across) * kPanelWidth;
  const double height = kTitle + static_cast<double>(down) * line_height;
  std::string text = gnuplot_terminal(static_cast<int>(width), static_cast<int>(height));
  text += fmt::format("set multiplot title {}\nset key off\nset grid xtics\nset yrange [0.5:{}.5]\nset ytics ()\n",
                      gnuplot_string(plot.title), rows);
  for (std::size_t p = 0; p < plot.panels.size(); ++p) {
    const double left = labels + static_cast<double>(p % across) * kPanelWidth;
    const std::size_t line = p / across;
    const double top = kTitle + static_cast<double>(line) * line_height + kAbovePanel;  // from above
    text += fmt::format("set lmargin at screen {:.4f}\nset rmargin at screen {:.4f}\n", left / width,
                        (left + kPanelWidth - kBesidePanel) / width);
    text += fmt::format("set tmargin at screen {:.4f}\nset bmargin at screen {:.4f}\n", 1.0 - top / height,
                        1.0 - (top + panel_height) / height);
    std::string tics;
    for (std::size_t i = 0; i < rows; ++i) {
      tics += fmt::format("{}{} {}", i == 0 ? "" : ", ",
                          gnuplot_string(p % across == 0 ? plot.settings[i] : std::string()), rows - i);
    }
    text += fmt::format("set ytics ({})\nset title {}\n", tics, gnuplot_string(plot.panels[p].title));
    text += "plot '-' using 1:2:3:4 with xerrorbars pointtype 7 pointsize 0.6 linecolor rgb '#1f5fa8'\n" +
            data_of(plot, plot.panels[p]);
  }
  return text + "unset multiplot\n";
}

Result<void> write_plot(const IntervalPlot& plot, const std::filesystem::path& path) {
  return draw_by_gnuplot(to_gnuplot(plot), path);
}

}  // namespace coppice
