#include <gtest/gtest.h>

#include "common/tree/guard.hpp"
#include "coordinator/exchange/cpp_header.hpp"
#include "coordinator/exchange/guarded_code.hpp"
#include "coordinator/exchange/py_trees_code.hpp"
#include "coordinator/exchange/python_function.hpp"
#include "coordinator/exchange/tikz.hpp"
#include "tests/common/tree/arbitrary.hpp"

// That the programs do what the tree does is for the judges (tests/judges), which run them.
namespace coppice {
namespace {

TEST(GuardedCode, falls_through_where_a_branch_fails_and_returns_where_the_tree_acts) {
  const Vocabulary uav = arbitrary::uav();
  const Problem problem = unlabelled(uav);
  const Tree tree = arbitrary::tree(
      "(selector (sequence s0=1 s5=3) (sequence (selector s3=0 (sequence s1=0 s2=0)) (selector (sequence s4=1 "
      "turn_left) turn_right)) move)",
      uav);
  const std::string text = to_python_function({tree, uav, problem, "uav.coppice"});
  EXPECT_NE(text.find("    if o[\"s0\"] == 1 and o[\"s5\"] == 3:\n"
                      "        return None\n"
                      "    if o[\"s3\"] == 0 or (o[\"s1\"] == 0 and o[\"s2\"] == 0):\n"
                      "        if o[\"s4\"] == 1:\n"
                      "            return \"turn_left\"\n"
                      "        return \"turn_right\"\n"
                      "    return \"move\"\n"),
            std::string::npos)
      << text;
}

TEST(CppHeader, gives_words_of_the_language_another_name) {
  const Vocabulary vocabulary = {{{"class", {0, 1}}, {"class_", {0, 1}}, {"_X", {0, 1}}, {"a__b", {0, 1}}},
                                 {"delete", "none", "Action"}};
  const Problem problem = unlabelled(vocabulary);
  const Tree tree = arbitrary::tree("(sequence class=0 class_=1 _X=0 a__b=1 delete)", vocabulary);
  const std::string text = to_cpp_header({tree, vocabulary, problem, "a\\\nb"});
  EXPECT_NE(text.find("if (o.class__ == 0 && o.class_ == 1 && o.X == 0 && o.a_b == 1) {"), std::string::npos) << text;
  EXPECT_NE(text.find("case Action::delete_: return \"delete\";"), std::string::npos) << text;
  EXPECT_EQ(text.find('\\'), std::string::npos) << text;
}

TEST(Tikz, prints_names_and_labels_as_they_are) {
  const Vocabulary vocabulary = {{{"a_b", {0, 1}, true, true}}, {"go_on"}};
  Problem problem = unlabelled(vocabulary);
  problem.features[0].values = {{0, "50 % {x}"}};
  const std::string text =
      to_tikz({arbitrary::tree("(sequence a_b=0 a_b<=1 go_on)", vocabulary), vocabulary, problem, "o"});
  EXPECT_NE(text.find("[{a\\_b$=0$\\\\{\\footnotesize a\\_b is 50 \\% \\{x\\}}}, condition]"), std::string::npos)
      << text;
  EXPECT_NE(text.find("[{go\\_on}, action]"), std::string::npos) << text;
}

}  // namespace
}  // namespace coppice
