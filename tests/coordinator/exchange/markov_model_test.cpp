#include "coordinator/exchange/markov_model.hpp"

#include <gtest/gtest.h>
#include <sstream>

#include "coordinator/exchange/drn_writer.hpp"
#include "coordinator/exchange/dtcontrol.hpp"
#include "coordinator/exchange/prism_explicit.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

// Two states, x=0 and x=1; `go` was tried ten times in the first (1 to itself, 9 on, reward -0.5 each), `wait` never;
// in the second only `wait` was, which stays and earns 2.
Chain two_states() {
  ChainParts parts;
  parts.vocabulary = {{{"x", {0, 1}}}, {"go", "wait"}};
  parts.features = {0, 1};
  parts.row_begin = {0, 2, 2, 2, 3};
  parts.successor = {0, 1, 1};
  parts.count = {1, 9, 4};
  parts.reward_sum = {-5.0, 0.0, 0.0, 8.0};
  parts.q = {0.0, 0.0, 0.0, 0.0};
  parts.policy = {ActionId{0}, ActionId{1}};
  parts.visits = {10, 4};
  return *Chain::make(std::move(parts));
}

std::string drn(const MarkovModel& model, bool intervals = false) {
  std::ostringstream out;
  write_drn(model, intervals, out);
  return out.str();
}

TEST(MarkovModel, has_a_choice_for_every_action_that_was_tried) {
  const Chain chain = two_states();
  EXPECT_EQ(drn(MarkovModel(chain, nullptr, {})),
            "// Written by coppice\n@type: MDP\n@value_type: double\n@parameters\n\n@reward_models\ngain cost\n"
            "@nr_states\n3\n@nr_choices\n3\n@model\n"
            "state 0 [0, 0] init\n//[x=0]\n\taction go [0, 0.5]\n\t\t0 : 0.10000000000000001\n\t\t1 : "
            "0.90000000000000002\n"
            "state 1 [0, 0]\n//[x=1]\n\taction wait [2, 0]\n\t\t1 : 1\n"
            "state 2 [0, 0] unknown\n\taction stay [0, 0]\n\t\t2 : 1\n");
}

TEST(MarkovModel, sends_what_a_tree_does_and_learning_never_tried_to_unknown) {
  const Chain chain = two_states();
  const Tree go = arbitrary::tree("go", chain.vocabulary());
  const std::string text = drn(MarkovModel(chain, &go, {{"there", {false, true}}}));
  EXPECT_NE(text.find("@type: DTMC"), std::string::npos) << text;
  EXPECT_NE(text.find("state 1 [0, 0] there\n//[x=1]\n\taction leave [0, 0]\n\t\t2 : 1\n"), std::string::npos) << text;
}

TEST(MarkovModel, holds_the_state_where_a_tree_does_not_act) {
  const Chain chain = two_states();
  const Tree silent = arbitrary::tree("(sequence x=0 go)", chain.vocabulary());
  const std::string text = drn(MarkovModel(chain, &silent, {}));
  EXPECT_NE(text.find("state 1 [0, 0]\n//[x=1]\n\taction hold [0, 0]\n\t\t1 : 1\n"), std::string::npos) << text;
}

TEST(MarkovModel, starts_from_a_state_of_its_own_where_episodes_have_several_starts) {
  ChainParts parts = two_states().parts();
  parts.starts = {{0, 1}, {1, 3}};
  const Chain chain = *Chain::make(std::move(parts));
  const MarkovModel model(chain, nullptr, {});
  EXPECT_EQ(model.initial(), 3U);
  EXPECT_NE(drn(model).find("state 3 [0, 0] init start\n\taction start [0, 0]\n\t\t0 : 0.25\n\t\t1 : 0.75\n"),
            std::string::npos)
      << drn(model);
}

TEST(MarkovModel, has_rows_that_sum_to_one_exactly_and_intervals_around_them) {
  Xoshiro256 random(73);
  for (int round = 0; round < 300; ++round) {
    ChainParts parts = two_states().parts();
    parts.count = {static_cast<std::uint32_t>(1 + random.below(1000)),
                   static_cast<std::uint32_t>(1 + random.below(1U << 31U)), 4};
    const Chain chain = *Chain::make(std::move(parts));
    const MarkovModel model(chain, nullptr, {});
    std::vector<ModelChoice> choices;
    for (std::size_t state = 0; state < model.states(); ++state) {
      model.choices_of(state, choices);
      for (const ModelChoice& choice : choices) {
        double sum = 0.0;
        double low = 0.0;
        double high = 0.0;
        for (const ModelTarget& target : choice.targets) {
          ASSERT_GT(target.low, 0.0);
          ASSERT_LE(target.low, target.probability);
          ASSERT_GE(target.high, target.probability);
          sum += target.probability;
          low += target.low;
          high += target.high;
        }
        ASSERT_EQ(sum, 1.0);
        ASSERT_LE(low, 1.0);
        ASSERT_GE(high, 1.0);
      }
    }
  }
}

TEST(PrismExplicit, writes_files_that_stand_beside_one_another) {
  const Chain chain = two_states();
  const MarkovModel model(chain, nullptr, {});
  std::string all;
  for (const PrismPart& part : prism_parts(model)) {
    std::ostringstream out;
    write_prism(model, part.file, out);
    all += part.extension + ":\n" + out.str();
  }
  EXPECT_EQ(all,
            ".tra:\n3 3 4\n0 0 0 0.10000000000000001 go\n0 0 1 0.90000000000000002 go\n1 0 1 1 wait\n2 0 2 1 stay\n"
            ".sta:\n(x,_kind)\n0:(0,0)\n1:(1,0)\n2:(0,1)\n"
            ".lab:\n0=\"init\" 1=\"deadlock\" 2=\"terminal\" 3=\"unknown\" 4=\"start\"\n0: 0\n2: 3\n"
            ".gain.trew:\n3 3 1\n1 0 1 2\n"
            ".cost.trew:\n3 3 2\n0 0 0 0.5\n0 0 1 0.5\n");
}

TEST(DtControl, writes_a_line_a_state) {
  std::ostringstream out;
  write_dtcontrol(two_states(), out);
  EXPECT_EQ(out.str(), "#NON-PERMISSIVE\n#BEGIN 1 1\n0,0\n1,1\n");
}

}  // namespace
}  // namespace coppice
