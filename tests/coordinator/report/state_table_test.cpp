#include "coordinator/report/state_table.hpp"

#include <gtest/gtest.h>
#include <sstream>

#include "common/tree/text.hpp"

namespace coppice {
namespace {

ChainParts two_states() {
  ChainParts parts;
  parts.vocabulary.features = {{"s3", {0, 1, 3}, true, false}, {"b", {0, 1}, true, false}};
  parts.vocabulary.actions = {"move", "turn_left"};
  parts.features = {0, 1, 3, 0};
  parts.row_begin = {0, 1, 1, 1, 2};
  parts.successor = {1, 0};
  parts.count = {7, 2};
  parts.reward_sum = {3.0, 0.0, 0.0, -1.0};
  parts.q.assign(4, 0.0);
  parts.policy = {ActionId{1}, ActionId{0}};
  parts.visits = {7, 2};
  return parts;
}

TEST(StateTable, HasARowAStateAndAnEmptyFieldWhereTheTreeSelectsNothing) {
  const auto chain = Chain::make(two_states());
  ASSERT_TRUE(chain) << chain.error().message;
  const auto tree = parse_tree("(sequence s3=0 move)", chain->vocabulary());
  ASSERT_TRUE(tree) << tree.error().message;
  std::ostringstream out;
  write_state_table(*chain, *tree, out);
  EXPECT_EQ(out.str(),
            "s3,b,visits,policy_action,tree_action\n"
            "0,1,7,turn_left,move\n"
            "3,0,2,move,\n");
}

}  // namespace
}  // namespace coppice
