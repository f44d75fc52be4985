// Means with intervals, setting by setting, as a picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/error.hpp"

namespace coppice {

struct PlotPoint {
  double value = 0.0;
  double low = 0.0;  // of the bar through it
  double high = 0.0;
};

// One panel: a measure over all settings.
struct PlotPanel {
  std::string title;
  std::vector<PlotPoint> points;  // one per setting
};

struct IntervalPlot {
  std::string title;
  std::vector<std::string> settings;  // labels, at least one
  std::vector<PlotPanel> panels;      // at least one
};

// What gnuplot is told, without where to: three panels side by side, the rest below.
std::string to_gnuplot(const IntervalPlot& plot);

// Writes it as an SVG. Errors: as draw_by_gnuplot(). REQUIRES: each panel has as many points as there are settings.
Result<void> write_plot(const IntervalPlot& plot, const std::filesystem::path& path);

}  // namespace coppice
