#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

using WrongUse = CommandLine;

const std::vector<std::string> kCommands = {"run",  "learn", "evolve", "score",    "prune",
                                            "draw", "table", "info",   "evaluate", "refine"};

TEST_F(WrongUse, EveryCommandExplainsItselfWithAnExample) {
  for (const std::string& name : kCommands) {
    const Completed help = coppice({name, "--help"});
    EXPECT_EQ(help.ending, kDone) << name;
    EXPECT_NE(help.output.find("  coppice " + name), std::string::npos) << help.output;
    EXPECT_EQ(help.error, "");
  }
}

TEST_F(WrongUse, TheVersionIsOneLine) {
  const Completed version = coppice({"--version"});
  EXPECT_EQ(version.ending, kDone);
  EXPECT_EQ(version.output.rfind("coppice ", 0), 0U);
  EXPECT_EQ(lines_of(version.output).size(), 1U);
}

TEST_F(WrongUse, AMissingOrUnknownCommandOrFlagIsNamed) {
  expect_wrong_use({}, {"subcommand", "--help"});
  expect_wrong_use({"grow"}, {"grow"});
  expect_wrong_use({"learn"}, {"--output"});
  expect_wrong_use({"learn", "-o", "a.coppice", "--episode", "3"}, {"--episode"});
  expect_wrong_use({"evolve"}, {"STUDY"});
  expect_wrong_use({"--log-level", "loud", "info", "x"}, {"loud"});
}

TEST_F(WrongUse, AFlagWithoutItsValueIsNotTakenForNone) {
  expect_wrong_use({"score", "x", "--tree", ""}, {"--tree is empty"});
  expect_wrong_use({"evolve", "x", "--config", ""}, {"--config is empty"});
  expect_wrong_use({"run", "-o", ""}, {"--output is empty"});
  expect_wrong_use({"learn", "-o", ""}, {"--output is empty"});
}

TEST_F(WrongUse, FlagsThatContradictEachOtherAreRefused) {
  expect_wrong_use({"evolve", "x", "--serial", "--workers", "2"}, {"--serial", "--workers"});
  expect_wrong_use({"evolve", "x", "--serial", "--remote"}, {"--serial", "--remote"});
  expect_wrong_use({"evolve", "x", "--resume", "--seed", "2"}, {"--resume", "--seed"});
  expect_wrong_use({"evolve", "x", "--resume", "--set", "ga.population=5"}, {"--resume", "--set"});
  expect_wrong_use({"evolve", "x", "--take-over"}, {"--take-over", "--resume"});
  expect_wrong_use({"evaluate", "x", "--interface", "lo"}, {"--interface", "--remote"});
  expect_wrong_use({"score", "x", "--tree", "move", "--run", "1"}, {"--tree", "--run"});
}

TEST_F(WrongUse, AFileThatIsNoStudyIsNamedByEveryCommand) {
  write("text.coppice", "this is not a study\n");
  for (const char* file : {"text.coppice", "missing.coppice"}) {
    expect_wrong_use({"info", file}, {file});
    expect_wrong_use({"score", file, "--tree", "move"}, {file});
    expect_wrong_use({"table", file, "--tree", "move"}, {file});
    expect_wrong_use({"prune", file, "--tree", "move"}, {file});
    expect_wrong_use({"draw", file, "--tree", "move", "-o", "t.dot"}, {file});
    expect_wrong_use({"evolve", file, "--serial"}, {file});
    expect_wrong_use({"evaluate", file, "--serial"}, {file});
  }
  EXPECT_EQ(files(), std::vector<std::string>{"text.coppice"});
}

TEST_F(WrongUse, ADrawingOfAnotherFormatIsRefusedBeforeAnythingElse) {
  expect_wrong_use({"draw", "missing.coppice", "-o", "t.pdf"}, {"t.pdf", ".svg", ".png", ".dot"});
}

}  // namespace
}  // namespace coppice::e2e
