// A coordinator that is killed loses nothing: resumed, it ends with the very result of a run that was left alone.
#include <signal.h>

#include "tests/e2e/cli/evolved_study.hpp"

namespace coppice::e2e {
namespace {

class Resume : public EvolvedStudy {
 protected:
  // An evolution of study.coppice over two workers, whose coordinator is killed once it has printed `line`.
  void kill_at(const std::string& line, std::vector<std::string> settings) const {
    settings.insert(settings.end(), {"--workers", "2", "--lines-every", "1"});
    Process coordinator(command(evolve("study.coppice", settings)));
    coordinator.await_error(line);
    coordinator.signal(SIGKILL);
    EXPECT_EQ(coordinator.wait().signal, SIGKILL);
  }
};

TEST_F(Resume, AfterTheCoordinatorWasKilledAgainAndAgainGivesTheSameResult) {
  // How far ahead of its lines a coordinator is when it is killed, nobody knows: a resumed one is killed at whatever
  // line it begins with.
  const std::vector<std::string> settings = {"--seed",          "4", "--set", "ga.generations=6000", "--set",
                                             "ga.population=50"};
  const auto expected = serial_runs(settings);
  kill_at("evolve: 70/6000", settings);
  kill_at("evolve: ", {"--resume"});
  kill_at("evolve: ", {"--resume"});
  coppice_json(evolve("study.coppice", {"--resume", "--workers", "1", "--json"}));
  expect_same_runs("study.coppice", expected);
}

TEST_F(Resume, OfAFrontGivesTheSameFrontWithAndWithoutWorkers) {
  std::vector<std::string> settings = {"--seed", "4"};
  for (const char* setting :
       {"ga.search=front", "ga.generations=40", "ga.population=50", "ga.edits=0.7", "ga.local_search=0.4",
        "ga.seeding=greedy", "front.restarts=1", "fitness.regret=0.1", "rollout.final_method=exact",
        "front.objectives=agreement, coverage, regret, collisions, nodes"}) {
    settings.insert(settings.end(), {"--set", setting});
  }
  const auto expected = serial_runs(settings);
  kill_at("evolve: 25/40", settings);
  coppice_json(evolve("study.coppice", {"--resume", "--workers", "1", "--json"}));
  expect_same_runs("study.coppice", expected);
  const auto front = coppice_json({"front", "study.coppice", "--json"});
  EXPECT_EQ(front, coppice_json({"front", "serial.coppice", "--json"}));
  EXPECT_GT(front.size(), 1U);
}

TEST_F(Resume, OfARunThatIsStillGoingIsRefused) {
  Process going(command(evolve("study.coppice", {"--serial", "--lines-every", "1", "--set", "ga.generations=100000"})));
  going.await_error("evolve: 3/");
  const Completed refused = coppice(evolve("study.coppice", {"--resume", "--serial"}));
  EXPECT_NE(refused.ending, kDone);
  EXPECT_NE(refused.error.find("run 1"), std::string::npos) << refused.error;
  going.signal(SIGINT);
  EXPECT_EQ(going.wait(), kInterrupted);
}

TEST_F(Resume, OfNothingIsRefused) {
  expect_wrong_use(evolve("study.coppice", {"--resume", "--serial"}), {"study.coppice"});
}

}  // namespace
}  // namespace coppice::e2e
