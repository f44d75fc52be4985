// How both programs end: each row of common/exit_code.hpp, by what really happens.
#include <signal.h>

#include "common/exit_code.hpp"
#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

class ExitCodes : public RemoteStudy {
 protected:
  ExitCodes() { domain_ = "210"; }

  static Ending ending(ExitCode code) { return {to_int(code), 0}; }
  static Ending of_worker(std::vector<std::string> arguments) {
    return run_to_end({.program = COPPICE_WORKER_PROGRAM, .arguments = std::move(arguments)}).ending;
  }
};

TEST_F(ExitCodes, AreThoseOfTheTable) {
  EXPECT_EQ(coppice({"info", "study.coppice"}).ending, ending(ExitCode::finished));
  EXPECT_EQ(coppice({"evolve", "study.coppice", "--serial", "--resume", "--run", "7"}).ending,
            ending(ExitCode::bad_input));
  EXPECT_EQ(coppice({"evolve", "study.coppice", "--remote", "--domain", "300"}).ending, ending(ExitCode::wrong_use));
  EXPECT_EQ(coppice({"evolve"}).ending, ending(ExitCode::wrong_use));
  EXPECT_EQ(coppice({"help", "nothing"}).ending, ending(ExitCode::wrong_use));
  write("text.coppice", "no study\n");
  EXPECT_EQ(coppice({"info", "text.coppice"}).ending, ending(ExitCode::bad_input));
  EXPECT_EQ(coppice({"evolve", "study.coppice", "--remote", "--domain", domain_, "--wait", "1"}).ending,
            ending(ExitCode::no_worker));
  EXPECT_EQ(shell("\"$0\" info study.coppice > /dev/full").ending, ending(ExitCode::environment));
}

TEST_F(ExitCodes, TellAnInterruptionWhichKeptTheBestSoFar) {
  Process going(command(evolve("study.coppice", {"--serial", "--set", "ga.generations=100000", "--lines-every", "1"})));
  going.await_error("evolve: 3/100000");
  going.signal(SIGTERM);
  EXPECT_EQ(going.wait(), ending(ExitCode::interrupted));
  EXPECT_EQ(coppice({"info", "study.coppice"}).ending, ending(ExitCode::finished));
}

TEST_F(ExitCodes, TellADamagedStudy) {
  const std::string whole = read("study.coppice");
  write("cut.coppice", whole.substr(0, whole.size() / 2));
  EXPECT_EQ(coppice({"info", "cut.coppice"}).ending, ending(ExitCode::study_damaged));
  EXPECT_EQ(coppice({"check", "cut.coppice"}).ending, ending(ExitCode::study_damaged));
}

TEST_F(ExitCodes, HoldForTheWorkerToo) {
  EXPECT_EQ(of_worker({"--thread", "2"}), ending(ExitCode::wrong_use));
  EXPECT_EQ(of_worker({"--pace", "soon"}), ending(ExitCode::wrong_use));
  EXPECT_EQ(of_worker({"--security", path("nowhere")}), ending(ExitCode::wrong_use));
  EXPECT_EQ(of_worker({"--health", "1"}), ending(ExitCode::environment));
  Process& standing = start_worker(0);
  standing.await_error("looks for a coordinator");
  standing.signal(SIGTERM);
  EXPECT_EQ(standing.wait(), ending(ExitCode::finished));
}

TEST_F(ExitCodes, AreListedByHelp) {
  const std::string topic = coppice({"help", "exit-codes"}).output;
  const std::string of_program = run_to_end({.program = COPPICE_WORKER_PROGRAM, .arguments = {"--help"}}).output;
  for (const ExitCodeRow& row : kExitCodes) {
    EXPECT_NE(topic.find(row.meaning), std::string::npos) << topic;
    EXPECT_NE(of_program.find(row.meaning), std::string::npos) << of_program;
  }
}

}  // namespace
}  // namespace coppice::e2e
