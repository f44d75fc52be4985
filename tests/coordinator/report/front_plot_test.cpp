#include "coordinator/report/front_plot.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>

#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

// Of one leaf each, by coverage, return and collisions.
const Front kFront{{measure_of(ObjectiveKind::coverage), measure_of(ObjectiveKind::expected_return),
                    measure_of(ObjectiveKind::collisions), kNodesMeasure},
                   {{Tree(ActionId{0}), 0.1, {0.5, 30.0, 2.0, 1}},
                    {Tree(ActionId{1}), 0.4, {0.7, 20.0, 1.0, 1}},
                    {Tree(ActionId{2}), 0.3, {0.6, 10.0, 0.0, 1}}}};

FrontAxes axes(const char* text) { return axes_from(text, kFront).value(); }

TEST(FrontPlot, JoinsWhatNoOtherBeatsInTheTwoMeasures) {
  const std::string text = to_gnuplot(kFront, axes("coverage,return"), 2);
  EXPECT_NE(text.find("set xlabel 'coverage'\nset format x '%g %%'\n"), std::string::npos) << text;
  EXPECT_NE(text.find("set ylabel 'return'\nset format y '%g'\n"), std::string::npos) << text;
  // The joined ones, all, the picked one.
  EXPECT_NE(text.find("\n70 20 1\n50 30 1\ne\n50 30 1\n70 20 1\n60 10 1\ne\n60 10 1\ne\n"), std::string::npos) << text;
}

TEST(FrontPlot, KnowsThatCostsAreToBeSmall) {
  const std::string text = to_gnuplot(kFront, axes("coverage,collisions"), {});
  EXPECT_NE(text.find("\n70 1 1\n60 0 1\ne\n50 2 1\n"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("\n60 0 1\ne\n")) << text;
}

TEST(FrontPlot, IsDrawn) {
  const testing::TemporaryFolder folder;
  const auto written = write_front_plot(kFront, axes("collisions,return"), 1, folder / "front.svg");
  ASSERT_TRUE(written) << written.error().message;
  std::ifstream in(folder / "front.svg");
  const std::string svg{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(svg.find("collisions"), std::string::npos);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
}

TEST(FrontPlot, IsAPngWhereTheNameSaysSo) {
  const testing::TemporaryFolder folder;
  const auto written = write_front_plot(kFront, axes("collisions,return"), 1, folder / "front.png");
  ASSERT_TRUE(written) << written.error().message;
  std::ifstream in(folder / "front.png", std::ios::binary);
  const std::string png{std::istreambuf_iterator<char>(in), {}};
  EXPECT_TRUE(png.starts_with("\x89PNG"));
}

TEST(FrontPlot, OfAnotherNameOrInAMissingFolderIsRefusedWithTheReason) {
  const testing::TemporaryFolder folder;
  const auto refusal = [&](const std::string& path) {
    const auto written = write_front_plot(kFront, axes("collisions,return"), 1, path);
    EXPECT_FALSE(written) << path;
    return written ? "" : written.error().message;
  };
  const std::string jpeg = folder / "front.jpg";
  EXPECT_EQ(refusal(jpeg), jpeg + ": picture has extension '.jpg': expected .svg or .png");
  const std::string lost = folder / "missing/front.svg";
  EXPECT_EQ(refusal(lost), "cannot write " + lost + ": No such file or directory");
}

}  // namespace
}  // namespace coppice
