// A table of the thesis beside ours, as text and as JSON.
#include "coordinator/reproduce/comparison.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

const Comparison kTable{.name = "Table 1",
                        .title = "a title",
                        .printed_columns = {"policy", "tree"},
                        .our_columns = {"policy"},
                        .rows = {{"reward", {"283", "248"}, {"285.2 +- 7.3"}}, {"collisions", {}, {"0"}}},
                        .remarks = {"Why."}};

TEST(Comparison, StandsInColumnsBehindABar) {
  EXPECT_EQ(to_text(kTable),
            "Table 1: a title\n"
            "            the thesis    | this run\n"
            "            policy  tree  | policy\n"
            "reward      283     248   | 285.2 +- 7.3\n"
            "collisions                | 0\n"
            "- Why.\n");
}

TEST(Comparison, LongRemarksAreBrokenBetweenWords) {
  Comparison table = kTable;
  table.remarks = {std::string(100, 'a') + ' ' + std::string(30, 'b') + " c"};
  const std::string text = to_text(table);
  EXPECT_NE(text.find("- " + std::string(100, 'a') + "\n  " + std::string(30, 'b') + " c\n"), std::string::npos)
      << text;
}

TEST(Comparison, JsonHasEveryCell) {
  const auto json = to_json(kTable);
  EXPECT_EQ(json["rows"][0]["thesis"][1], "248");
  EXPECT_EQ(json["rows"][1]["this_run"][0], "0");
  EXPECT_EQ(json["remarks"][0], "Why.");
}

}  // namespace
}  // namespace coppice
