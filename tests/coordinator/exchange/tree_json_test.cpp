#include "coordinator/exchange/tree_json.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "coordinator/exchange/tree_file.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

std::string read(const std::string& json, const Vocabulary& vocabulary = arbitrary::uav()) {
  const Result<Tree> tree = parse_tree_json(json, "x.json", vocabulary);
  return tree ? to_text(*tree, vocabulary) : tree.error().message;
}

TEST(TreeJson, reads_back_what_it_wrote_in_every_scale) {
  Xoshiro256 random(72);
  const Vocabulary vocabulary = {{{"plain", {0, 3, 7}, true, true},
                                  {"number", {0, 1, 2}, true, true, Scale::numbers, {-1.5, 0.1, 1e30}},
                                  {"bin", {0, 1, 2}, false, true, Scale::bins, {-0.25, 1e-9}}},
                                 {"go", "stop"}};
  ASSERT_TRUE(check_vocabulary(vocabulary));
  Problem problem = unlabelled(vocabulary);
  problem.features[0] = {"a \"label\"", "m/s", {{3, "three\nlines"}}};
  for (int round = 0; round < 300; ++round) {
    const Tree tree = grow_tree(vocabulary, {1 + random.below(6), 4}, true, arbitrary::below_of(random));
    const std::string json = to_tree_json({tree, vocabulary, problem, "\xFF"});
    ASSERT_EQ(read(json, vocabulary), to_text(tree, vocabulary)) << json;
    ASSERT_EQ(nlohmann::json::parse(json)["text"], to_text(tree, vocabulary));
    ASSERT_EQ(tree_form("\n " + json), TreeForm::json);
  }
}

TEST(TreeJson, names_the_place_in_the_tree_that_is_wrong) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"[1]", "x.json: not a JSON object"},
      {"{\"tree\": 1}", "tree: found number: expected a node"},
      {"{\"type\": \"x\"}", "tree.type: found \"x\": expected sequence, selector, condition or action"},
      {"{\"type\": \"sequence\", \"children\": []}", "tree.children: found []"},
      {"{\"type\": \"sequence\", \"children\": [{\"type\": \"action\", \"action\": \"fly\"}]}",
       "tree.children[0].action: found \"fly\": expected one of move, turn_left, turn_right"},
      {"{\"type\": \"condition\", \"feature\": \"s3\", \"op\": \"=\", \"value\": 2}", "tree.value: found 2"},
      {"{\"type\": \"condition\", \"feature\": \"s3\", \"op\": \"<=\", \"value\": 1}",
       "tree.op: found \"<=\": expected ="},
      {"{\"type\": \"condition\", \"op\": \"=\", \"value\": 1}", "tree.feature: found nothing"},
  };
  for (const auto& [json, message] : cases) {
    EXPECT_NE(read(json).find(message), std::string::npos) << json << "\n" << read(json);
  }
}

TEST(TreeJson, keeps_the_limits_of_trees) {
  std::string deep;
  for (int i = 0; i < 100; ++i) {
    deep += "{\"type\":\"sequence\",\"children\":[";
  }
  EXPECT_NE(read(deep + "{\"type\":\"action\",\"action\":\"move\"}" +
                 [] {
                   std::string end;
                   for (int i = 0; i < 100; ++i) {
                     end += "]}";
                   }
                   return end;
                 }())
                .find("64 edges"),
            std::string::npos);
}

}  // namespace
}  // namespace coppice
