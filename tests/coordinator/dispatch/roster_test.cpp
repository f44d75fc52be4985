#include "coordinator/dispatch/roster.hpp"

#include <gtest/gtest.h>

namespace coppice {
namespace {

using namespace std::chrono_literals;
using Speaker = Roster::Speaker;

HelloHeard hello(std::uint64_t worker, std::uint8_t origin) {
  HelloHeard heard;
  heard.worker = WorkerId{worker};
  heard.origin = Origin{origin};
  return heard;
}

TEST(Roster, GivesANameToWhomItHeardFirstUnderIt) {
  Roster roster;
  EXPECT_EQ(roster.speaker(WorkerId{1}, Origin{1}), Speaker::first);
  roster.meet(hello(1, 1));
  EXPECT_EQ(roster.speaker(WorkerId{1}, Origin{1}), Speaker::own);
  EXPECT_EQ(roster.speaker(WorkerId{1}, Origin{2}), Speaker::other);
  EXPECT_EQ(roster.speaker(WorkerId{1}, std::nullopt), Speaker::unknown);
  roster.let_go(WorkerId{1});
  EXPECT_EQ(roster.speaker(WorkerId{1}, Origin{2}), Speaker::other) << "for good";
}

TEST(Roster, RemembersTheNamesOfThoseWhoLeftLastAlone) {
  Roster roster;
  for (std::uint64_t worker = 1; worker <= Roster::kMaxRemembered + 1; ++worker) {
    roster.meet(hello(worker, 1));
    roster.let_go(WorkerId{worker});
  }
  EXPECT_EQ(roster.speaker(WorkerId{1}, Origin{2}), Speaker::first);
  EXPECT_EQ(roster.speaker(WorkerId{2}, Origin{2}), Speaker::other);
}

TEST(Roster, CallsSilentWhoWasNotHeardWhileItListened) {
  Roster roster;
  InFlight::Time now{};
  roster.listen(now);
  roster.hear(roster.meet(hello(1, 1)), hello(1, 1));
  roster.listen(now += 1h);
  EXPECT_TRUE(roster.silent().empty()) << "an hour without listening";
  for (int i = 0; i < 10; ++i) {
    roster.listen(now += 200ms);
  }
  EXPECT_EQ(roster.silent(), std::vector<WorkerId>{WorkerId{1}});
  roster.hear(*roster.find(WorkerId{1}), hello(1, 1));
  EXPECT_TRUE(roster.silent().empty());
}

TEST(Roster, GivesNoWorkerMoreLanesThanItsQueueOfTasksAllows) {
  Roster roster;
  HelloHeard many = hello(1, 1);
  many.lanes = 1'000'000;
  EXPECT_EQ(roster.meet(many).lanes, Roster::kMaxLanes);
  HelloHeard none = hello(2, 1);
  none.lanes = 0;
  EXPECT_EQ(roster.meet(none).lanes, 1U);
}

}  // namespace
}  // namespace coppice
