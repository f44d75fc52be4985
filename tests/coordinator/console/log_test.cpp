#include "coordinator/console/log.hpp"

#include <array>
#include <cstdio>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <regex>
#include <spdlog/spdlog.h>
#include <sstream>
#include <string>

namespace coppice {
namespace {

using std::chrono::milliseconds;

TEST(LineBudget, ShowsSoManyLinesAWindowAndCountsTheRest) {
  LineBudget budget(2, milliseconds(1000));
  const LineBudget::Time begin{std::chrono::hours(1)};
  EXPECT_TRUE(budget.next(begin).shown);
  EXPECT_TRUE(budget.next(begin + milliseconds(10)).shown);
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(budget.next(begin + milliseconds(999)).shown);
  }
  const auto verdict = budget.next(begin + milliseconds(1000));
  EXPECT_TRUE(verdict.shown);
  EXPECT_EQ(verdict.left_out, 5U);
  EXPECT_EQ(budget.next(begin + milliseconds(1001)).left_out, 0U);
}

TEST(Log, LinesArePrintableAndLessUrgentOnesStayAway) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  const auto before = spdlog::default_logger();
  log_to(file, spdlog::level::warn);
  spdlog::warn("worker {} left", "\x1b[2J");
  spdlog::info("not shown");
  spdlog::set_default_logger(before);
  std::rewind(file);
  std::array<char, 200> bytes{};
  const std::size_t size = std::fread(bytes.data(), 1, bytes.size(), file);
  std::fclose(file);
  EXPECT_EQ(std::string(bytes.data(), size), "coppice: worker \\x1b[2J left\n");
}

TEST(Log, AsJsonIsOneObjectALineWhateverAMessageHolds) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  const auto before = spdlog::default_logger();
  log_to(file, spdlog::level::warn, LogFormat::json);
  spdlog::warn("a \"quote\",\na new line and \xff");
  spdlog::error("second");
  spdlog::set_default_logger(before);
  std::rewind(file);
  std::array<char, 2000> bytes{};
  const std::string text(bytes.data(), std::fread(bytes.data(), 1, bytes.size(), file));
  std::fclose(file);
  std::istringstream lines(text);
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  const auto first = nlohmann::json::parse(line);
  EXPECT_EQ(first["level"], "warning");
  EXPECT_EQ(first["program"], "coppice");
  EXPECT_EQ(first["message"], "a \"quote\",\na new line and \xef\xbf\xbd");
  EXPECT_TRUE(
      std::regex_match(first["time"].get<std::string>(), std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z)")));
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(nlohmann::json::parse(line)["message"], "second");
  EXPECT_FALSE(std::getline(lines, line));
}

}  // namespace
}  // namespace coppice
