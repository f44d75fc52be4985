// The document that the page shows, and the file with it inside.
#include "coordinator/studio/page_data.hpp"

#include <gtest/gtest.h>

#include "common/tree/text.hpp"
#include "coordinator/report/on_chain.hpp"
#include "coordinator/studio/page_file.hpp"
#include "coordinator/studio/page_tree.hpp"
#include "coordinator/studio/shell_word.hpp"
#include "tests/coordinator/studio/studio_study.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;
using testing::StudioStudy;
using testing::tree_of;

const Tree kTree = tree_of("(selector (sequence a=0 move) (sequence b=3 right) move)");

TEST(PageData, HoldsWhatIsKnownOfTreeAndPolicy) {
  const StudioStudy files;
  const auto data = page_data(files.study, StudioStudy::request(kTree), {});
  ASSERT_TRUE(data) << data.error().message;
  EXPECT_EQ((*data)["format"], "coppice page");
  EXPECT_EQ((*data)["version"], kPageDataVersion);
  const Chain& chain = files.study.chain();
  const ExpectedScore expected = expected_score(chain, actions_of(chain, kTree), 30);
  EXPECT_NEAR((*data)["answer"]["tree"]["figures"]["reward"].get<double>(), expected.reward, 1e-4);
  EXPECT_NEAR((*data)["answer"]["tree"]["figures"]["agreement"].get<double>(), expected.agreement, 1e-5);
  EXPECT_EQ((*data)["answer"]["policy"]["coverage"], 1);
  EXPECT_EQ((*data)["answer"]["tree"]["figures"]["matching_states"], 54) << "27 of 81 states have a=0";
  const Json& rules = (*data)["answer"]["rules"];
  EXPECT_EQ(rules[0]["holds"], true);
  EXPECT_EQ(rules[1]["holds"], false);
  EXPECT_EQ(rules[1]["broken_by"]["features"][0], 0);
  EXPECT_TRUE(rules[2].contains("error"));
  EXPECT_EQ((*data)["disagreements"]["total"], 27);
  EXPECT_EQ((*data)["states"]["index"].size(), 81U);
  EXPECT_TRUE((*data)["world"].is_null());
  EXPECT_EQ((*data)["walks"].size(), 2U);
  EXPECT_EQ((*data)["walks"][0]["steps"].size(), 30U);
}

TEST(PageData, IsTheSameEachTime) {
  const StudioStudy files;
  EXPECT_EQ(*page_data(files.study, StudioStudy::request(kTree), {}),
            *page_data(files.study, StudioStudy::request(kTree), {}));
}

TEST(PageData, CanBeStopped) {
  const StudioStudy files;
  int asked = 0;
  const auto data = page_data(files.study, StudioStudy::request(kTree), [&](double) { return ++asked < 3; });
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().kind, ErrorKind::interrupted);
}

TEST(PageData, OfManyStatesShowsTheMostVisitedAndSaysHowMuchTheyHold) {
  const Chain chain = testing::small_chain();
  const std::vector<double> tree(chain.states(), 1.0);
  const Json states = states_json(chain, tree, tree);
  EXPECT_EQ(states["total"], 81);
  EXPECT_EQ(states["tree_share"], 1);
  EXPECT_EQ(states["features"].size(), 81U * chain.vocabulary().features.size());
  EXPECT_EQ(states["q"].size(), 81U * chain.actions());
}

TEST(ReportPage, HoldsItsDataWhereNothingInThemCanEndTheElement) {
  const std::string page = report_page({{"text", "</script><script>alert(1)</script><!-- \xe2\x80\xa8 $& "}});
  EXPECT_EQ(page.find("</script><script>alert"), std::string::npos);
  EXPECT_NE(page.find("\\u003c/script>\\u003cscript>alert(1)"), std::string::npos);
  EXPECT_NE(page.find("connect-src 'none'"), std::string::npos);
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

TEST(StudioPage, HoldsNoDataAndMayAskWhereItCameFrom) {
  const std::string page = studio_page();
  EXPECT_EQ(page.find("id=\"coppice-data\""), std::string::npos);
  EXPECT_NE(page.find("connect-src 'self'"), std::string::npos);
}

TEST(ShellWord, IsWhatAShellReadsBack) {
  EXPECT_EQ(shell_word("uav.coppice"), "uav.coppice");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("(sequence s3=0 move)"), "'(sequence s3=0 move)'");
  EXPECT_EQ(shell_word("it's; rm -rf /"), "'it'\\''s; rm -rf /'");
}

}  // namespace
}  // namespace coppice
