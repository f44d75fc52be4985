// Help, completion, and words that were mistyped.
#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

using Help = CommandLine;

// The commands that `coppice --help` lists.
std::vector<std::string> commands_in(const std::string& help) {
  std::vector<std::string> commands;
  for (const std::string& line : lines_of(help)) {
    if (line.size() > 2 && line.starts_with("  ") && line[2] >= 'a' && line[2] <= 'z') {
      commands.push_back(line.substr(2, line.find(' ', 2) - 2));
    }
  }
  return commands;
}

TEST_F(Help, GroupsEveryCommandByWhatItIsFor) {
  const std::string help = coppice({"--help"}).output;
  std::size_t last = 0;
  for (const char* group : {"Begin:", "Get a chain:", "Evolve:", "Look:", "Trust:", "Change:", "Run a fleet:"}) {
    EXPECT_NE(help.find(std::string("\n") + group), std::string::npos) << group << " in " << help;
    last = std::max(last, help.find(group));
  }
  EXPECT_GT(commands_in(help).size(), 20U);
}

TEST_F(Help, ExplainsCommandsAndTopics) {
  EXPECT_EQ(coppice({"help", "front"}).output, coppice({"front", "--help"}).output);
  const std::string keys = coppice({"help", "keys"}).output;
  EXPECT_NE(keys.find("ga.population"), std::string::npos);
  EXPECT_NE(keys.find("M of the thesis: individuals, in all demes together"), std::string::npos);
  EXPECT_NE(coppice({"help", "rules"}).output.find("never move when s3=0"), std::string::npos);
  const std::string all = coppice({"help"}).output;
  for (const char* topic : {"trees", "rules", "pick", "keys", "files", "environment"}) {
    EXPECT_NE(all.find(std::string("\n  ") + topic + " "), std::string::npos) << topic;
    EXPECT_GT(lines_of(coppice({"help", topic}).output).size(), 2U) << topic;
  }
  expect_wrong_use({"help", "rulse"}, {"'rulse'", "did you mean rules?"});
  expect_wrong_use({"help", "weather"}, {"'weather'", "coppice help"});
}

TEST_F(Help, SuggestsWhatWasMeant) {
  expect_wrong_use({"evovle", "x"}, {"'evovle' is no command", "did you mean evolve?"});
  expect_wrong_use({"weather"}, {"'weather' is no command (see"});
  expect_wrong_use({"evolve", "x", "--wokers", "2"}, {"'--wokers'", "did you mean --workers?"});
  expect_wrong_use({"learn", "--outptu", "x"}, {"'--outptu'", "did you mean --output?"});
  expect_wrong_use({"info", "x", "--weather"}, {"'--weather' was not expected (see"});
}

TEST_F(Help, BashCompletesCommandsFlagsAndValues) {
  const auto completes = [&](const std::string& words, const std::string& expected) {
    const Completed completed = shell(
        "bash -c 'eval \"$(\"$0\" completion bash)\"; COMP_WORDS=(coppice " + words +
        "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _coppice; printf \"%s\\n\" \"${COMPREPLY[@]}\" | sort' \"$0\"");
    EXPECT_EQ(completed.ending, kDone) << completed.error;
    EXPECT_EQ(completed.error, "");
    EXPECT_EQ(completed.output, expected) << words;
  };
  completes("eva", "evaluate\n");
  completes("front --pl", "--plot\n");
  completes("--log-level i", "info\n");
  completes("--log-level info fro", "front\n");
  completes("completion --h", "--help\n");
  completes("help rep",
            coppice({"--help"}).output.find("\n  report") != std::string::npos ? "report\nreproduce\n" : "reproduce\n");
  write("uav.coppice", "");
  completes("info ua", "uav.coppice\n");
  completes("front uav.coppice --plot ua", "uav.coppice\n");
}

TEST_F(Help, EveryShellGetsEveryCommandAndFlag) {
  const std::vector<std::string> commands = commands_in(coppice({"--help"}).output);
  for (const char* name : {"bash", "zsh", "fish"}) {
    const Completed script = coppice({"completion", name});
    ASSERT_EQ(script.ending, kDone);
    for (const std::string& command : commands) {
      EXPECT_NE(script.output.find(command), std::string::npos) << command << " for " << name;
    }
    EXPECT_NE(script.output.find("cross-check"), std::string::npos);
    write(name, script.output);
    // Where that shell is not installed its script is only looked through.
    const Completed parsed =
        shell(std::string("command -v ") + name + " >/dev/null || exit 0; " + name + " -n " + name);
    EXPECT_EQ(parsed.ending, kDone) << name << ": " << parsed.error;
  }
  expect_wrong_use({"completion", "tcsh"}, {"tcsh", "bash"});
}

}  // namespace
}  // namespace coppice::e2e
