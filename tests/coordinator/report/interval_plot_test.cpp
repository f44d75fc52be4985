#include "coordinator/report/interval_plot.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>

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
