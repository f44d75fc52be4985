// The problem that a study holds, and studies from before there was one.
#include <filesystem>
#include <gtest/gtest.h>

#include "coordinator/problem/world_problem.hpp"
#include "tests/coordinator/study/study_fixture.hpp"

namespace coppice {
namespace {

using ProblemStudyTest = testing::StudyFiles;

Problem labelled(const Chain& chain) {
  Problem problem = unlabelled(chain.vocabulary());
  problem.title = "a \"room\"";
  problem.source = "model.drn (Storm DRN)";
  problem.features[0] = {.label = "ahead", .unit = "m", .values = {{0, "wall"}, {3, "trash"}}};
  problem.action_labels[2] = "go right";
  problem.discount = 0.99;
  problem.simulator = "python3 -m coppice.gym CartPole-v1";
  return problem;
}

Problem labelled_windy(const Study& study) {
  Problem problem = study.problem();
  problem.title = "wind";
  return problem;
}

TEST_F(ProblemStudyTest, KeepsItsProblem) {
  const Problem problem = labelled(chain_);
  { ASSERT_TRUE(Study::create(path_, chain_, world_, learning_, problem).has_value()); }
  Problem changed = problem;
  changed.simulator = "other";
  {
    auto study = Study::open(path_);
    ASSERT_TRUE(study.has_value()) << study.error().message;
    EXPECT_EQ(study->problem(), problem);
    ASSERT_TRUE(study->save_problem(changed).has_value());
    EXPECT_EQ(study->problem(), changed);
  }
  EXPECT_EQ(Study::open(path_, Study::Access::read)->problem(), changed);
}

TEST_F(ProblemStudyTest, WithoutOneItIsThatOfItsWorld) {
  const Study study = make();
  EXPECT_EQ(study.problem(), problem_of_world("uav", chain_.vocabulary()));
}

// Made by the program of schema 3: 'coppice learn --world windy --episodes 300', then a run of 3 generations.
TEST_F(ProblemStudyTest, AStudyOfSchemaThreeOpensAndIsBroughtUpToDate) {
  std::filesystem::copy_file(std::string(COPPICE_SOURCE_DIR) + "/tests/coordinator/study/kept/schema_3.study", path_);
  const std::string before = content();
  std::string hash;
  {
    const auto study = Study::open(path_, Study::Access::read);
    ASSERT_TRUE(study.has_value()) << study.error().message;
    EXPECT_EQ(study->problem(), problem_of_world("windy", study->chain().vocabulary()));
    EXPECT_EQ(study->problem().features[0].label, "column");
    EXPECT_EQ(study->generations(RunId{1}).value().size(), 3U);
    hash = study->chain_hash().hex();
  }
  EXPECT_EQ(content(), before);
  {
    auto study = Study::open(path_);
    ASSERT_TRUE(study.has_value()) << study.error().message;
    EXPECT_EQ(study->chain_hash().hex(), hash);
    EXPECT_EQ(study->generations(RunId{1}).value().size(), 3U);
    EXPECT_TRUE(study->resume_run(RunId{1}).has_value() || study->run(RunId{1})->status == RunStatus::finished);
    ASSERT_TRUE(study->save_problem(labelled_windy(*study)).has_value());
  }
  EXPECT_EQ(Study::open(path_, Study::Access::read)->problem().title, "wind");
}

TEST_F(ProblemStudyTest, AProblemThatDoesNotFitIsDamage) {
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"[]", "problem: expected a JSON object"},
           {R"({"features":{"zz":{}}})", "problem.features.zz: there is no such feature"},
           {R"({"features":{"a":{"values":{"2":"x"}}}})", "problem.features.a.values.2"},
           {R"({"features":{"a":7}})", "problem.features.a: expected an object"},
           {R"({"actions":{"fly":"x"}})", "problem.actions.fly: there is no such action"},
           {R"({"discount":1.5})", "problem.discount: expected a number from 0 to 1"},
           {R"({"title":7})", "problem.title: expected a text"}}) {
    const auto problem = problem_from_json(text, chain_.vocabulary());
    ASSERT_FALSE(problem.has_value()) << text;
    EXPECT_NE(problem.error().message.find(message), std::string::npos) << problem.error().message;
  }
}

TEST_F(ProblemStudyTest, WordsSayWhatLabelsKnow) {
  const Problem problem = labelled(chain_);
  const Vocabulary& vocabulary = chain_.vocabulary();
  EXPECT_EQ(in_words(Node::condition(0, Op::equal, 3), problem, vocabulary), "ahead is trash");
  EXPECT_EQ(in_words(Node::condition(0, Op::equal, 1), problem, vocabulary), "ahead is 1 m");
  EXPECT_EQ(in_words(Node::condition(1, Op::equal, 1), problem, vocabulary), "");
  EXPECT_EQ(in_words(Node::action(ActionId{2}), problem, vocabulary), "go right");
  EXPECT_EQ(in_words(Node::action(ActionId{0}), problem, vocabulary), "");
}

}  // namespace
}  // namespace coppice
