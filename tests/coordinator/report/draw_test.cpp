#include "coordinator/report/draw.hpp"

#include <filesystem>
#include <gtest/gtest.h>
#include <regex>
#include <set>
#include <string>

#include "common/chain/random.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/text.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice {
namespace {

Vocabulary two_sensors() {
  Vocabulary vocabulary;
  vocabulary.features = {{"s3", {0, 1, 3}, true, false}, {"near", {0, 1}, true, true}};
  vocabulary.actions = {"move", "turn_left"};
  return vocabulary;
}

TEST(Draw, LabelsNodesAsTheThesisDoes) {
  const Vocabulary vocabulary = two_sensors();
  const auto tree = parse_tree("(selector (sequence s3=0 turn_left) near<=1 move)", vocabulary);
  ASSERT_TRUE(tree) << tree.error().message;
  EXPECT_EQ(to_dot(*tree, vocabulary, unlabelled(vocabulary)),
            "digraph tree {\n"
            "  graph [ordering=out];\n"
            "  node [fontname=\"Helvetica\", fontsize=12];\n"
            "  edge [arrowsize=0.6];\n"
            "  n0 [shape=square, label=\"?\"];\n"
            "  n1 [shape=square, label=\"\u2192\"];\n"
            "  n0 -> n1;\n"
            "  n2 [shape=ellipse, label=\"s3=0\"];\n"
            "  n1 -> n2;\n"
            "  n3 [shape=box, label=\"turn_left\"];\n"
            "  n1 -> n3;\n"
            "  n4 [shape=ellipse, label=\"near<=1\"];\n"
            "  n0 -> n4;\n"
            "  n5 [shape=box, label=\"move\"];\n"
            "  n0 -> n5;\n"
            "}\n");
}

TEST(Draw, QuotesAndBackslashesInANameCannotLeaveTheirLabel) {
  Vocabulary vocabulary = two_sensors();
  vocabulary.actions[0] = "a\"];x\\";
  EXPECT_NE(to_dot(Tree(ActionId{0}), vocabulary, unlabelled(vocabulary)).find("label=\"a\\\"];x\\\\\"];"),
            std::string::npos);
}

TEST(Draw, PutsWhatAConditionSaysInWordsUnderIt) {
  const Vocabulary vocabulary = two_sensors();
  Problem problem = unlabelled(vocabulary);
  problem.features[0] = {"ahead", "", {{0, "a \"wall\""}}};
  const auto tree = parse_tree("(sequence s3=0 move)", vocabulary);
  ASSERT_TRUE(tree) << tree.error().message;
  EXPECT_NE(to_dot(*tree, vocabulary, problem).find("label=\"s3=0\\nahead is a \\\"wall\\\"\"];"), std::string::npos)
      << to_dot(*tree, vocabulary, problem);
}

TEST(Draw, EveryNodeButTheRootHasExactlyOneEdgeIntoIt) {
  const Vocabulary vocabulary = two_sensors();
  Stream random(1, Purpose::growing, 0, 0);
  const Below below = [&](std::uint64_t n) { return random.below(n); };
  const std::regex edge("n([0-9]+) -> n([0-9]+);");
  for (int i = 0; i < 200; ++i) {
    const Tree tree = grow_tree(vocabulary, {.max_depth = 5, .max_children = 4}, true, below);
    const std::string dot = to_dot(tree, vocabulary, unlabelled(vocabulary));
    std::set<std::size_t> children;
    std::size_t edges = 0;
    for (std::sregex_iterator match(dot.begin(), dot.end(), edge), end; match != end; ++match, ++edges) {
      const std::size_t parent = std::stoul((*match)[1]);
      const std::size_t child = std::stoul((*match)[2]);
      children.insert(child);
      EXPECT_TRUE(tree[parent].is_composite());
      EXPECT_EQ(tree.depth_of(child), tree.depth_of(parent) + 1);
    }
    EXPECT_EQ(edges, tree.size() - 1);
    EXPECT_EQ(children.size(), tree.size() - 1);
    EXPECT_FALSE(children.contains(0));
  }
}

TEST(Draw, AnotherExtensionIsBadInputThatNamesTheThree) {
  for (const char* name : {"tree.pdf", "tree", "tree.SVG", ".svg"}) {
    const auto format = drawing_format(name);
    ASSERT_FALSE(format) << name;
    EXPECT_EQ(format.error().kind, ErrorKind::bad_input);
    for (const char* extension : {".svg", ".png", ".dot"}) {
      EXPECT_NE(format.error().message.find(extension), std::string::npos);
    }
  }
}

// Restores the working directory.
class InFolder {
 public:
  explicit InFolder(const std::filesystem::path& folder) { std::filesystem::current_path(folder); }
  InFolder(const InFolder&) = delete;
  InFolder& operator=(const InFolder&) = delete;
  ~InFolder() { std::filesystem::current_path(before_); }

 private:
  std::filesystem::path before_ = std::filesystem::current_path();
};

TEST(Draw, ANameThatBeginsWithADashIsAName) {
  const testing::TemporaryFolder folder;
  const InFolder there(folder.path());
  std::filesystem::create_directory("-weird");
  for (const char* name : {"-Tpng.svg", "-weird/tree.png"}) {
    const auto written = write_drawing(Tree(ActionId{0}), two_sensors(), unlabelled(two_sensors()), name);
    EXPECT_TRUE(written) << written.error().message;
    EXPECT_TRUE(std::filesystem::exists(name)) << name;
  }
}

}  // namespace
}  // namespace coppice
