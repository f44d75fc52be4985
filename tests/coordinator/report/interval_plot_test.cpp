#include "coordinator/report/interval_plot.hpp"

#include <cstdio>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <utility>

#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

IntervalPlot plot_of(std::string label) {
  return {
      .title = "two settings",
      .settings = {"a=1", std::move(label)},
      .panels = {{"agreement", {{0.5, 0.4, 0.6}, {0.7, 0.7, 0.7}}}, {"reward", {{1.0, 0.0, 2.0}, {3.0, 2.0, 4.0}}}}};
}

TEST(IntervalPlot, HasAPanelForEachMeasureAndTheFirstSettingOnTop) {
  const std::string text = to_gnuplot(plot_of("a=2"));
  EXPECT_NE(text.find("set ytics ('a=1' 2, 'a=2' 1)\nset title 'agreement'\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\n0.5 2 0.4 0.6\n0.7 1 0.7 0.7\ne\n"), std::string::npos) << text;
  EXPECT_NE(text.find("set title 'reward'"), std::string::npos) << text;
}

// The width and the height that gnuplot is told, in pixels.
std::pair<int, int> size_of(const std::string& text) {
  std::pair<int, int> size;
  EXPECT_EQ(std::sscanf(text.c_str(), "set terminal svg size %d,%d ", &size.first, &size.second), 2) << text;
  return size;
}

TEST(IntervalPlot, OfManyMeasuresFitsAScreenAndGrowsDownwards) {
  IntervalPlot plot = plot_of("a=2");
  const PlotPanel panel = plot.panels[0];
  plot.panels.assign(3, panel);
  const auto [width_of_three, height_of_three] = size_of(to_gnuplot(plot));
  plot.panels.assign(10, panel);
  const std::string text = to_gnuplot(plot);
  const auto [width, height] = size_of(text);
  EXPECT_EQ(width, width_of_three);
  EXPECT_LT(width, 1200);
  EXPECT_GT(height, 3 * height_of_three);
  // Each line of panels names the settings again, and none lies outside the picture.
  std::size_t named = 0;
  for (std::size_t at = text.find("'a=1'"); at != std::string::npos; at = text.find("'a=1'", at + 1)) {
    ++named;
  }
  EXPECT_EQ(named, 4U);
  EXPECT_EQ(text.find("at screen -"), std::string::npos) << text;
}

TEST(IntervalPlot, IsDrawnWhateverALabelHolds) {
  const testing::TemporaryFolder folder;
  const std::string hostile = "it's `touch " + (folder / "made") + "`\n\"$x\"; quit";
  const auto written = write_plot(plot_of(hostile), folder / "plot.svg");
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_FALSE(std::filesystem::exists(folder / "made"));
  std::ifstream in(folder / "plot.svg");
  const std::string svg{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(svg.find("it's `touch"), std::string::npos);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
}

}  // namespace
}  // namespace coppice
