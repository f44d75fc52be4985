#include <gtest/gtest.h>

#include "common/tree/guard.hpp"
#include "coordinator/exchange/behavior_tree_names.hpp"
#include "coordinator/exchange/behavior_tree_reader.hpp"
#include "coordinator/exchange/behavior_tree_xml.hpp"
#include "tests/common/tree/arbitrary.hpp"

namespace coppice {
namespace {

Problem labelled_room() {
  Problem problem = unlabelled(arbitrary::uav());
  problem.features[3] = {"ahead", "", {{0, "wall"}, {1, "free"}}};
  problem.action_labels[1] = "turn to the \"left\" <&>";
  return problem;
}

std::string xml_of(const Tree& tree, BehaviorTreeStyle style = BehaviorTreeStyle::scripts) {
  const Result<std::string> xml = to_behavior_tree_xml({tree, arbitrary::uav(), labelled_room(), "a -- b"}, style);
  return xml ? *xml : xml.error().message;
}

std::string read(const std::string& xml, const Vocabulary& vocabulary = arbitrary::uav()) {
  const Result<Tree> tree = parse_behavior_tree_xml(xml, "x.xml", vocabulary);
  return tree ? to_text(*tree, vocabulary) : tree.error().message;
}

std::string wrapped(const std::string& nodes) {
  return "<root BTCPP_format=\"4\" main_tree_to_execute=\"Policy\"><BehaviorTree ID=\"Policy\">" + nodes +
         "</BehaviorTree></root>";
}

TEST(BehaviorTreeXml, writes_scripts_that_need_nothing_registered) {
  const Tree tree = arbitrary::tree("(selector (sequence s3=0 turn_left) move)", arbitrary::uav());
  EXPECT_NE(xml_of(tree).find("    <Fallback>\n"
                              "      <Sequence>\n"
                              "        <ScriptCondition code=\"s3 == 0\" name=\"ahead is wall (s3=0)\"/>\n"
                              "        <Script code=\"action := 1\" name=\"turn to the &quot;left&quot; &lt;&amp;&gt; "
                              "(turn_left)\"/>\n"
                              "      </Sequence>\n"
                              "      <Script code=\"action := 0\" name=\"move\"/>\n"
                              "    </Fallback>\n"),
            std::string::npos)
      << xml_of(tree);
}

TEST(BehaviorTreeXml, names_nodes_that_the_robot_registers_and_declares_each_once) {
  const Tree tree = arbitrary::tree("(selector (sequence s3=0 move) (sequence s3=1 move))", arbitrary::uav());
  const std::string xml = xml_of(tree, BehaviorTreeStyle::nodes);
  EXPECT_NE(xml.find("<Condition ID=\"s3_is_0\" name=\"ahead is wall (s3=0)\"/>"), std::string::npos) << xml;
  EXPECT_NE(xml.find("  <TreeNodesModel>\n    <Condition ID=\"s3_is_0\"/>\n    <Action ID=\"move\"/>\n"
                     "    <Condition ID=\"s3_is_1\"/>\n  </TreeNodesModel>\n"),
            std::string::npos)
      << xml;
}

TEST(BehaviorTreeXml, reads_back_what_it_wrote_for_random_trees_of_random_vocabularies_in_both_styles) {
  Xoshiro256 random(71);
  for (int space = 0; space < 50; ++space) {
    Vocabulary vocabulary = arbitrary::vocabulary(random, 1 + random.below(4), 4, 1 + random.below(4));
    vocabulary.features[0].name = "action";  // an entry of the blackboard has that name
    vocabulary.actions[0] = "Sequence";      // and so has a node of the library
    if (random.below(2) == 0) {
      Feature& feature = vocabulary.features[0];
      feature.scale = Scale::bins;
      feature.admits_equal = false;
      feature.admits_less_equal = true;
      for (std::size_t i = 1; i < feature.values.size(); ++i) {
        feature.numbers.push_back(static_cast<double>(i) * 1e-7 - 0.25);
      }
    }
    ASSERT_TRUE(check_vocabulary(vocabulary));
    const Problem problem = unlabelled(vocabulary);
    for (int round = 0; round < 20; ++round) {
      const Tree tree = grow_tree(vocabulary, {1 + random.below(5), 3}, true, arbitrary::below_of(random));
      const Tree guarded = *guard(tree, vocabulary);
      const auto scripts = to_behavior_tree_xml({tree, vocabulary, problem, "o"}, BehaviorTreeStyle::scripts);
      ASSERT_TRUE(scripts) << scripts.error().message;
      ASSERT_EQ(read(*scripts, vocabulary), to_text(tree, vocabulary)) << *scripts;
      const auto nodes = to_behavior_tree_xml({guarded, vocabulary, problem, "o"}, BehaviorTreeStyle::nodes);
      ASSERT_TRUE(nodes) << nodes.error().message;
      ASSERT_EQ(read(*nodes, vocabulary), to_text(guarded, vocabulary)) << *nodes;
    }
  }
}

TEST(BehaviorTreeXml, refuses_numbers_that_scripts_cannot_tell_apart) {
  Vocabulary vocabulary = {{{"x", {0, 1}, true, true, Scale::numbers, {1.0, 1.00000005}}}, {"go"}};
  const Problem problem = unlabelled(vocabulary);
  const auto xml =
      to_behavior_tree_xml({arbitrary::tree("x=1", vocabulary), vocabulary, problem, "o"}, BehaviorTreeStyle::scripts);
  ASSERT_FALSE(xml);
  EXPECT_NE(xml.error().message.find("cannot tell them apart"), std::string::npos);
}

TEST(BehaviorTreeReader, takes_reactive_composites_subtrees_and_compact_tags) {
  EXPECT_EQ(read(wrapped("<ReactiveFallback><ReactiveSequence><ScriptCondition code=\"s3&lt;=0\"/><move/>"
                         "</ReactiveSequence></ReactiveFallback>"),
                 {{{"s3", {0, 1}, true, true}}, {"move"}}),
            "(selector (sequence s3<=0 move))");
  EXPECT_EQ(read("<root BTCPP_format=\"4\" main_tree_to_execute=\"A\"><BehaviorTree ID=\"A\"><Fallback><SubTree "
                 "ID=\"B\"/><Script code=\"action:=move\"/></Fallback></BehaviorTree><BehaviorTree ID=\"B\"><Sequence>"
                 "<s3_is_0/><Action ID=\"turn_left\"/></Sequence></BehaviorTree></root>"),
            "(selector (sequence s3=0 turn_left) move)");
}

TEST(BehaviorTreeReader, refuses_by_name_and_line_what_has_no_counterpart) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {wrapped("\n<Inverter><move/></Inverter>"), "x.xml: line 2: found a node 'Inverter'"},
      {wrapped("<SequenceWithMemory><move/></SequenceWithMemory>"), "found a node 'SequenceWithMemory'"},
      {wrapped("<Sequence _skipIf=\"s3==0\"><move/></Sequence>"), "found attribute '_skipIf' of <Sequence>"},
      {wrapped("<Script code=\"action:=1; s3:=2\"/>"), "found the script 'action:=1; s3:=2'"},
      {wrapped("<ScriptCondition code=\"s3==0 &amp;&amp; s1==0\"/>"), "found the script 's3==0 && s1==0'"},
      {wrapped("<ScriptCondition code=\"s3==2\"/>"), "expected a value of 's3': one of 0, 1, 3"},
      {wrapped("<ScriptCondition code=\"s3&lt;=1\"/>"), "expected == after 's3'"},
      {wrapped("<Sequence></Sequence>"), "found <Sequence> without children"},
      {wrapped("<move/><move/>"), "a <BehaviorTree> with several children"},
      {wrapped("<Sequence>"), "not well-formed XML"},
      {"<root main_tree_to_execute=\"A\"><BehaviorTree ID=\"A\"><move/></BehaviorTree></root>", "BTCPP_format"},
      {"<root BTCPP_format=\"4\" main_tree_to_execute=\"A\"><BehaviorTree ID=\"A\"><SubTree ID=\"A\"/></BehaviorTree>"
       "</root>",
       "a SubTree inside itself"},
      {"<tree/>", "expected <root>"},
      {"", "not well-formed XML"},
  };
  for (const auto& [xml, message] : cases) {
    EXPECT_NE(read(xml).find(message), std::string::npos) << xml << "\n" << read(xml);
  }
}

TEST(BehaviorTreeReader, keeps_the_limits_of_trees_whatever_subtrees_repeat) {
  std::string xml = "<root BTCPP_format=\"4\" main_tree_to_execute=\"T0\">";
  for (int i = 0; i < 40; ++i) {
    xml += fmt::format(
        "<BehaviorTree ID=\"T{}\"><Sequence><SubTree ID=\"T{}\"/><SubTree ID=\"T{}\"/></Sequence>"
        "</BehaviorTree>",
        i, i + 1, i + 1);
  }
  xml += "<BehaviorTree ID=\"T40\"><move/></BehaviorTree></root>";
  EXPECT_NE(read(xml).find("expected at most 4096 nodes"), std::string::npos) << read(xml);
}

TEST(BehaviorTreeNames, gives_every_condition_of_a_vocabulary_one_id) {
  const Result<NodeIds> ids = node_ids(arbitrary::uav());
  ASSERT_TRUE(ids);
  EXPECT_EQ(ids->conditions.size(), 24U);
  EXPECT_EQ(ids->conditions.at("s3_is_0"), Node::condition(3, Op::equal, 0));
  const Vocabulary clash = {{{"s", {0, 1}}}, {"s_is_1"}};
  ASSERT_FALSE(node_ids(clash));
  EXPECT_NE(node_ids(clash).error().message.find("'s_is_1'"), std::string::npos);
}

}  // namespace
}  // namespace coppice
