// What commands write, and that they overwrite nothing unasked.
#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

using Output = CommandLine;

TEST_F(Output, AFileThatExistsIsOverwrittenOnlyByForce) {
  learn_study();
  const std::vector<std::vector<std::string>> commands = {
      {"draw", "study.coppice", "--tree", "move", "-o", "kept.dot"},
      {"table", "study.coppice", "--tree", "move", "-o", "kept.dot"},
      {"edit", "study.coppice", "--tree", "move", "--episodes", "2", "-o", "kept.dot"},
  };
  for (std::vector<std::string> command : commands) {
    write("kept.dot", "precious\n");
    expect_wrong_use(command, {"-o kept.dot exists", "--force"});
    EXPECT_EQ(read("kept.dot"), "precious\n") << command.front();
    command.emplace_back("--force");
    EXPECT_EQ(coppice(command).ending, kDone) << command.front();
    EXPECT_NE(read("kept.dot"), "precious\n") << command.front();
  }
}

TEST_F(Output, TheStudyItselfIsNeverOverwritten) {
  learn_study();
  const std::string before = read("study.coppice");
  for (const char* command : {"table", "edit"}) {
    expect_wrong_use({command, "study.coppice", "--tree", "move", "-o", "study.coppice", "--force"}, {"study itself"});
  }
  EXPECT_EQ(read("study.coppice"), before);
}

TEST_F(Output, ADeviceIsWrittenTo) {
  learn_study();
  const Completed table = coppice({"table", "study.coppice", "--tree", "move", "-o", "/dev/stdout"});
  EXPECT_EQ(table.ending, kDone) << table.error;
  EXPECT_GT(lines_of(table.output).size(), 10U);
}

TEST_F(Output, AFolderMayHaveAnyName) {
  const Completed run = coppice({"run", "-o", "-weird", "--config", "thesis", "--serial", "--episodes", "300",
                                 "--score-episodes", "5", "--set", "ga.generations=3", "--set", "ga.population=8"});
  EXPECT_EQ(run.ending, kDone) << run.error;
  EXPECT_TRUE(exists("-weird/study.coppice"));
}

}  // namespace
}  // namespace coppice::e2e
