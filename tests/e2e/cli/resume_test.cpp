// A coordinator that is killed loses nothing: resumed, it ends with the very result of a run that was left alone.
#include <signal.h>

#include "tests/e2e/cli/evolved_study.hpp"

namespace coppice::e2e {
namespace {

class Resume : public EvolvedStudy {};

TEST_F(Resume, AfterTheCoordinatorWasKilledAgainAndAgainGivesTheSameResult) {
  write("other.coppice", read("study.coppice"));
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=900", "--set", "ga.population=50"};
  std::vector<std::string> alone = settings;
  alone.insert(alone.end(), {"--serial", "--json"});
  const auto expected = coppice_json(evolve("other.coppice", alone));

  std::vector<std::string> first = settings;
  first.insert(first.end(), {"--workers", "2", "--lines-every", "1"});
  Process killed(command(evolve("study.coppice", first)));
  killed.await_error("evolve: 70/900");
  killed.signal(SIGKILL);
  EXPECT_EQ(killed.wait().signal, SIGKILL);
  for (const char* line : {"evolve: 200/900", "evolve: 400/900"}) {
    Process again(command(evolve("study.coppice", {"--resume", "--workers", "2", "--lines-every", "1"})));
    again.await_error(line);
    again.signal(SIGKILL);
    EXPECT_EQ(again.wait().signal, SIGKILL);
  }
  const auto resumed = coppice_json(evolve("study.coppice", {"--resume", "--workers", "1", "--json"}));
  EXPECT_EQ(figures(resumed), figures(expected));
  expect_same_runs("study.coppice", runs("other.coppice"));
}

TEST_F(Resume, OfAFrontGivesTheSameFrontWithAndWithoutWorkers) {
  write("other.coppice", read("study.coppice"));
  std::vector<std::string> settings = {"--seed", "4"};
  for (const char* setting : {"ga.search=front", "ga.generations=40", "ga.population=50", "ga.edits=0.7",
                              "ga.local_search=0.4", "ga.seeding=greedy", "front.restarts=1", "fitness.regret=0.1",
                              "front.objectives=agreement, coverage, regret, collisions, nodes"}) {
    settings.insert(settings.end(), {"--set", setting});
  }
  std::vector<std::string> alone = settings;
  alone.insert(alone.end(), {"--serial", "--json"});
  const auto expected = coppice_json(evolve("other.coppice", alone));
  std::vector<std::string> first = settings;
  first.insert(first.end(), {"--workers", "2", "--lines-every", "1"});
  Process killed(command(evolve("study.coppice", first)));
  killed.await_error("evolve: 25/40");
  killed.signal(SIGKILL);
  EXPECT_EQ(killed.wait().signal, SIGKILL);
  const auto resumed = coppice_json(evolve("study.coppice", {"--resume", "--workers", "1", "--json"}));
  EXPECT_EQ(figures(resumed), figures(expected));
  const auto front = coppice_json({"front", "study.coppice", "--json"});
  EXPECT_EQ(front, coppice_json({"front", "other.coppice", "--json"}));
  EXPECT_GT(front.size(), 1U);
}

TEST_F(Resume, OfARunThatIsStillGoingIsRefused) {
  Process going(command(evolve("study.coppice", {"--serial", "--lines-every", "1", "--set", "ga.generations=100000"})));
  going.await_error("evolve: 3/");
  const Completed refused = coppice(evolve("study.coppice", {"--resume", "--serial"}));
  EXPECT_NE(refused.ending, kDone);
  EXPECT_NE(refused.error.find("run 1"), std::string::npos) << refused.error;
  going.signal(SIGINT);
  EXPECT_EQ(going.wait(), kFailed);
}

TEST_F(Resume, OfNothingIsRefused) {
  expect_wrong_use(evolve("study.coppice", {"--resume", "--serial"}), {"study.coppice"});
}

}  // namespace
}  // namespace coppice::e2e
