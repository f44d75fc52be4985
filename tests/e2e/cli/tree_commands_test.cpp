// score, table, prune, draw and info: the commands that look at a tree and a study.
#include <fstream>
#include <signal.h>
#include <sys/stat.h>

#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

class TreeCommands : public CommandLine {
 protected:
  void SetUp() override { learn_study(); }
};

TEST_F(TreeCommands, ScoreReportsPolicyTreeAndPrunedTree) {
  const auto score = coppice_json({"score", "study.coppice", "--tree", "(sequence " + kWallTree + " " + kWallTree + ")",
                                   "--episodes", "20", "--json"});
  EXPECT_EQ(score["policy"]["agreement_over_states"], 1.0);
  EXPECT_EQ(score["nodes"]["tree"], 11);
  EXPECT_LE(score["nodes"]["pruned"], score["nodes"]["sound"]);
  EXPECT_LT(score["nodes"]["pruned"], 11);
  EXPECT_EQ(score["tree"]["matching_states"], score["pruned"]["matching_states"]);
  EXPECT_EQ(score["tree"]["steps"], 20 * 150);
  EXPECT_EQ(score["tree"]["collisions"], 0);
}

TEST_F(TreeCommands, ScoreSetsTheThesisBesideTheStudyInARoomOnly) {
  const Completed room = coppice({"score", "study.coppice", "--tree", kWallTree, "--episodes", "20"});
  EXPECT_EQ(room.ending, kDone) << room.error;
  EXPECT_NE(room.output.find("3123 entries"), std::string::npos) << room.output;
  ASSERT_EQ(coppice({"learn", "-o", "w.coppice", "--world", "windy", "--episodes", "200"}).ending, kDone);
  const Completed windy = coppice({"score", "w.coppice", "--tree", "x<=3", "--episodes", "20"});
  EXPECT_EQ(windy.ending, kDone) << windy.error;
  EXPECT_EQ(windy.output.find("3123 entries"), std::string::npos) << windy.output;
}

TEST_F(TreeCommands, TheSameScoreTwice) {
  const std::vector<std::string> arguments = {"score", "study.coppice", "--tree", kWallTree, "--episodes",
                                              "50",    "--json"};
  EXPECT_EQ(coppice(arguments).output, coppice(arguments).output);
}

TEST_F(TreeCommands, TableHasARowAStateAndWritesTheSameToAFile) {
  const Completed table = coppice({"table", "study.coppice", "--tree", kWallTree});
  EXPECT_EQ(table.ending, kDone) << table.error;
  const auto lines = lines_of(table.output);
  const auto states = coppice_json({"info", "study.coppice", "--json"})["states"].get<std::size_t>();
  EXPECT_EQ(lines.size(), states + 1);
  EXPECT_EQ(lines.front(), "s0,s1,s2,s3,s4,s5,s6,s7,visits,policy_action,tree_action");
  EXPECT_EQ(coppice({"table", "study.coppice", "--tree", kWallTree, "-o", "t.csv"}).ending, kDone);
  EXPECT_EQ(read("t.csv"), table.output);
}

TEST_F(TreeCommands, OutputThatCannotBeWrittenIsAFailure) {
  const Command shell{.program = "/bin/sh",
                      .arguments = {"-c", "exec \"$0\" table study.coppice --tree move > /dev/full", COPPICE_PROGRAM},
                      .folder = path(""),
                      .environment = {}};
  const Completed completed = run_to_end(shell);
  EXPECT_EQ(completed.ending, kFailed);
  EXPECT_NE(completed.error.find("standard output"), std::string::npos) << completed.error;
}

TEST_F(TreeCommands, StandardErrorThatCannotBeWrittenChangesNothing) {
  EXPECT_EQ(shell("\"$0\" evolve study.coppice --serial --set ga.generations=2 --lines-every 1 2>/dev/full").ending,
            kDone);
  EXPECT_EQ(shell("\"$0\" learn -o b.coppice --episodes 100 2>&-").ending, kDone);
  EXPECT_EQ(shell("\"$0\" info nofile 2>/dev/full").ending, kBadInput);
}

TEST_F(TreeCommands, ClosedStandardInputIsAnEmptyOne) {
  EXPECT_EQ(shell("\"$0\" evaluate study.coppice --serial <&-").ending, kDone);
}

TEST_F(TreeCommands, TheStudyIsNoOutput) {
  const std::string before = read("study.coppice");
  std::filesystem::create_hard_link(path("study.coppice"), path("other.dot"));
  expect_wrong_use({"table", "study.coppice", "--tree", "move", "-o", "study.coppice"}, {"study.coppice"});
  expect_wrong_use({"draw", "study.coppice", "--tree", "move", "-o", "other.dot"}, {"other.dot"});
  EXPECT_EQ(read("study.coppice"), before);
}

TEST_F(TreeCommands, AnInterruptionEndsScoring) {
  Process process(command({"score", "study.coppice", "--tree", "move", "--episodes", "100000000"}));
  process.await_blocked(SIGTERM);
  process.signal(SIGTERM);
  EXPECT_EQ(process.wait(), kInterrupted);
  EXPECT_NE(process.rest_of_error().find("interrupted"), std::string::npos);
}

TEST_F(TreeCommands, PruneGivesAReasonForEveryNodeThatWent) {
  const auto report = coppice_json({"prune", "study.coppice", "--tree",
                                    "(selector (sequence s3=0 turn_left) move turn_right)", "--sound", "--json"});
  EXPECT_EQ(report["pruned"], kWallTree);
  std::size_t gone = 0;
  for (const auto& removal : report["removals"]) {
    gone += removal["nodes"].get<std::size_t>();
    EXPECT_FALSE(removal["reason"].get<std::string>().empty());
  }
  EXPECT_EQ(gone, 1U);
  EXPECT_EQ(report["nodes"], 6);
  EXPECT_EQ(report["pruned_nodes"], 5);
}

TEST_F(TreeCommands, DrawWritesAllThreeFormats) {
  for (const char* name : {"t.dot", "t.svg", "t.png"}) {
    const Completed drawn = coppice({"draw", "study.coppice", "--tree", kWallTree, "-o", name});
    EXPECT_EQ(drawn.ending, kDone) << drawn.error;
  }
  EXPECT_EQ(read("t.dot").rfind("digraph", 0), 0U);
  EXPECT_NE(read("t.svg").find("</svg>"), std::string::npos);
  EXPECT_EQ(read("t.png").substr(1, 3), "PNG");
  EXPECT_EQ(files(), (std::vector<std::string>{"study.coppice", "t.dot", "t.png", "t.svg"}));
}

TEST_F(TreeCommands, ADrawingThatFailsHalfwayKeepsTheOldFile) {
  write("t.svg", "the old drawing");
  write("dot",
        "#!/bin/sh\nwhile [ $# -gt 0 ]; do [ \"$1\" = -o ] && printf half > \"$2\"; shift; done\n"
        "printf 'out of \\033[31mink\\n' >&2\nexit 3\n");
  ASSERT_EQ(chmod(path("dot").c_str(), 0755), 0);
  Command draw = command({"draw", "study.coppice", "--tree", kWallTree, "-o", "t.svg", "--force"});
  draw.environment = {{"PATH", path("")}};
  const Completed completed = run_to_end(draw);
  EXPECT_EQ(completed.ending, kFailed);
  EXPECT_NE(completed.error.find("exit code 3): out of \\x1b[31mink"), std::string::npos) << completed.error;
  EXPECT_EQ(read("t.svg"), "the old drawing");
  EXPECT_EQ(files(), (std::vector<std::string>{"dot", "study.coppice", "t.svg"}));
}

TEST_F(TreeCommands, DrawSaysWhenGraphvizIsMissing) {
  Command draw = command({"draw", "study.coppice", "--tree", kWallTree, "-o", "t.svg"});
  draw.environment = {{"PATH", path("")}};
  const Completed completed = run_to_end(draw);
  EXPECT_EQ(completed.ending, kFailed);
  EXPECT_NE(completed.error.find("install graphviz"), std::string::npos) << completed.error;
  EXPECT_EQ(files(), std::vector<std::string>{"study.coppice"});
}

TEST_F(TreeCommands, ATreeMayBeTextOrAFileWithComments) {
  write("best.tree", "# found by hand\n\n  " + kWallTree + "\t\n");
  const Completed from_file = coppice({"table", "study.coppice", "--tree", "best.tree"});
  EXPECT_EQ(from_file.ending, kDone) << from_file.error;
  EXPECT_EQ(from_file.output, coppice({"table", "study.coppice", "--tree", kWallTree}).output);
}

TEST_F(TreeCommands, AMalformedTreeIsNamedWithItsPlace) {
  write("bad.tree", "# a comment\n(selector move\n");
  write("two.tree", "move\nturn_left\n");
  write("none.tree", "\n");
  write("escape.tree", "\x1b[31mmove\n");
  expect_wrong_use({"score", "study.coppice", "--tree", "bad.tree"}, {"bad.tree", "line 2", "column"});
  expect_wrong_use({"score", "study.coppice", "--tree", "two.tree"}, {"two.tree", "more than one"});
  expect_wrong_use({"score", "study.coppice", "--tree", "none.tree"}, {"none.tree", "no tree"});
  expect_wrong_use({"score", "study.coppice", "--tree", "escape.tree"}, {"escape.tree", "\\x1b"});
  expect_wrong_use({"score", "study.coppice", "--tree", "(selector s9=0 move)"}, {"--tree", "column 11", "s9"});
  expect_wrong_use({"score", "study.coppice"}, {"study.coppice", "--tree"});
  expect_wrong_use({"score", "study.coppice", "--run", "4"}, {"4"});
}

TEST_F(TreeCommands, InfoSaysWhatIsInside) {
  const auto info = coppice_json({"info", "study.coppice", "--json"});
  EXPECT_EQ(info["rows"], 3 * info["states"].get<int>());
  EXPECT_GT(info["rows_never_tried"], 0);
  EXPECT_LT(info["rows_never_tried"], info["rows"]);
  EXPECT_GT(info["states_with_wall_ahead"], 0);
  EXPECT_EQ(info["initial_state"]["index"], 0);
  EXPECT_EQ(info["chain"].get<std::string>().size(), 32U);
  EXPECT_TRUE(info["runs"].empty());
  const Completed text = coppice({"info", "study.coppice"});
  EXPECT_NE(text.output.find("rows never tried"), std::string::npos) << text.output;
}

}  // namespace
}  // namespace coppice::e2e
