// The bookkeeping as sequences of calls; time is whatever the test says it is.
#include "coordinator/dispatch/in_flight.hpp"

#include <algorithm>
#include <deque>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "common/chain/random.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;
using LossCause = InFlight::LossCause;
using Settled = InFlight::Settled;

constexpr WorkerId kAnn{1};
constexpr WorkerId kBen{2};
constexpr InFlight::Time kStart{};

// A request of so many units.
RequestId begin(InFlight& flight, std::uint32_t units) {
  static std::uint64_t last = 0;
  const RequestId id{++last};
  flight.open(id);
  flight.add(id, units);
  return id;
}

InFlight two_workers(const InFlightLimits& limits = {}) {
  InFlight flight(limits);
  flight.add_worker(kAnn);
  flight.add_worker(kBen);
  return flight;
}

TEST(InFlight, HandsOutEveryUnitOnceAndIsDoneWhenAllAreSettled) {
  InFlight flight = two_workers();
  begin(flight, 10);
  const auto first = flight.offer(kAnn, 6, kStart, {.patience = 1s});
  const auto second = flight.offer(kBen, 6, kStart, {.patience = 1s});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->first, 0U);
  EXPECT_EQ(first->count, 6U);
  EXPECT_EQ(second->first, 6U);
  EXPECT_EQ(second->count, 4U);
  EXPECT_FALSE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
  EXPECT_EQ(flight.settle(first->id, kAnn, kStart).fresh.size(), 6U);
  EXPECT_FALSE(flight.done());
  EXPECT_EQ(flight.settle(second->id, kBen, kStart).kind, Settled::first);
  EXPECT_TRUE(flight.done());
}

TEST(InFlight, KeepsToTheCredit) {
  InFlight flight = two_workers({.ahead = 1});
  begin(flight, 10);
  EXPECT_TRUE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
  const auto second = flight.offer(kAnn, 1, kStart, {.patience = 1s});
  ASSERT_TRUE(second);
  EXPECT_FALSE(flight.can_take(kAnn));
  EXPECT_FALSE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
  flight.settle(second->id, kAnn, kStart);
  EXPECT_TRUE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
}

// Its answer is here, and a sample of it is being computed, when its process ends.
TEST(InFlight, BlamesNoUnitsThatADyingWorkerHadAnswered) {
  InFlight flight = two_workers({.ahead = 1});
  begin(flight, 10);
  const auto first = flight.offer(kAnn, 4, kStart, {.patience = 1s});
  const auto second = flight.offer(kAnn, 3, kStart, {.patience = 1s});
  flight.answered(first->id, kAnn);
  EXPECT_EQ(flight.lose_worker(kAnn, LossCause::died).suspect, 3U) << "it was at the second";
  EXPECT_EQ(flight.deaths({first->request, first->first}), 0U);
  EXPECT_EQ(flight.deaths({second->request, second->first}), 1U);
  EXPECT_EQ(flight.settle(first->id, kAnn, kStart).fresh.size(), 4U);
}

TEST(InFlight, CountsADuplicateAndAForeignAnswerAsNothing) {
  InFlight flight = two_workers();
  begin(flight, 2);
  const auto batch = flight.offer(kAnn, 2, kStart, {.patience = 1s});
  EXPECT_EQ(flight.settle(batch->id, kBen, kStart).kind, Settled::foreign);
  EXPECT_EQ(flight.settle(BatchId{99}, kAnn, kStart).kind, Settled::foreign);
  EXPECT_EQ(flight.settle(batch->id, kAnn, kStart).kind, Settled::first);
  EXPECT_EQ(flight.settle(batch->id, kAnn, kStart).kind, Settled::foreign);
  EXPECT_TRUE(flight.done());
}

TEST(InFlight, OffersALostWorkersUnitsFirst) {
  InFlight flight = two_workers();
  begin(flight, 10);
  flight.offer(kAnn, 4, kStart, {.patience = 1s});
  const auto loss = flight.lose_worker(kAnn, LossCause::died);
  EXPECT_EQ(loss.batches, 1U);
  EXPECT_EQ(loss.units, 4U);
  EXPECT_EQ(loss.apart, 0U);
  const auto again = flight.offer(kBen, 10, kStart, {.patience = 1s});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->first, 0U);
  EXPECT_EQ(again->count, 4U);
}

TEST(InFlight, TakesALateAnswerOfALostWorker) {
  InFlight flight = two_workers();
  begin(flight, 4);
  const auto batch = flight.offer(kAnn, 4, kStart, {.patience = 1s});
  flight.lose_worker(kAnn, LossCause::died);
  EXPECT_EQ(flight.settle(batch->id, kAnn, kStart).fresh.size(), 4U);
  EXPECT_TRUE(flight.done());
  EXPECT_EQ(flight.waiting(), 0U);
}

TEST(InFlight, OffersACopyOfAnOverdueBatchAndTakesWhicheverAnswersFirst) {
  InFlight flight = two_workers();
  begin(flight, 4);
  const auto original = flight.offer(kAnn, 4, kStart, {.patience = 1s});
  EXPECT_FALSE(flight.offer_copy(kBen, kStart + 999ms, {.patience = 1s}));
  EXPECT_EQ(flight.next_due(), kStart + 1s);
  const auto copy = flight.offer_copy(kBen, kStart + 1s, {.patience = 1s});
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->count, 4U);
  EXPECT_EQ(flight.settle(copy->id, kBen, kStart).fresh.size(), 4U);
  EXPECT_TRUE(flight.done());
  EXPECT_EQ(flight.settle(original->id, kAnn, kStart).kind, Settled::duplicate);
  EXPECT_EQ(flight.load(kAnn), 0U);
}

TEST(InFlight, MakesNoMoreCopiesThanItsLimit) {
  InFlight flight({.ahead = 0, .copies = 1});
  for (std::uint64_t w = 1; w <= 4; ++w) {
    flight.add_worker(WorkerId{w});
  }
  begin(flight, 1);
  flight.offer(WorkerId{1}, 1, kStart, {.patience = 1s});
  EXPECT_TRUE(flight.offer_copy(WorkerId{2}, kStart + 1s, {.patience = 1s}));
  EXPECT_FALSE(flight.offer_copy(WorkerId{3}, kStart + 1s, {.patience = 1s}));
}

TEST(InFlight, ChargesLeftoversOfEarlierRequestsToTheirWorker) {
  InFlight flight = two_workers({.ahead = 0});
  const RequestId first = begin(flight, 1);
  flight.offer(kAnn, 1, kStart, {.patience = 1s});
  const auto copy = flight.offer_copy(kBen, kStart + 1s, {.patience = 1s});
  flight.settle(copy->id, kBen, kStart);
  flight.close(first);
  begin(flight, 2);
  EXPECT_FALSE(flight.can_take(kAnn));  // still at work on the old batch
  EXPECT_TRUE(flight.can_take(kBen));
}

TEST(InFlight, SendsAUnitAtWhichWorkersDiedAloneAndThenKeepsItToBeComputedApart) {
  InFlight flight({.ahead = 1, .isolate_after = 2, .apart_after = 3});
  const RequestId request = begin(flight, 5);
  for (std::uint64_t death = 1; death <= 3; ++death) {
    const WorkerId worker{death};
    flight.add_worker(worker);
    const auto batch = flight.offer(worker, 5, kStart, {.patience = 1s});
    ASSERT_TRUE(batch);
    EXPECT_EQ(batch->first, 0U);
    EXPECT_EQ(batch->count, death == 3 ? 1U : 5U);  // alone in the end
    if (death == 3) {
      EXPECT_FALSE(flight.can_take(worker)) << "an isolated unit travels with nothing beside it";
    }
    const auto loss = flight.lose_worker(worker, LossCause::died);
    EXPECT_EQ(loss.apart, death == 3 ? 1U : 0U);
    EXPECT_EQ(loss.suspect, batch->count);
  }
  EXPECT_EQ(flight.deaths({request, 0}), 3U);
  EXPECT_EQ(flight.deaths({request, 1}), 2U);
  EXPECT_EQ(flight.waiting_apart(), 1U);
  EXPECT_EQ(flight.waiting(), 4U);
  const auto apart = flight.offer_apart(kStart);
  ASSERT_TRUE(apart);
  EXPECT_EQ(apart->first, 0U);
  EXPECT_FALSE(flight.offer_apart(kStart));
  EXPECT_EQ(flight.unsettled(), 5U) << "nothing is given up";
  EXPECT_EQ(flight.settle(apart->id, kHome, kStart).fresh, std::vector<std::uint32_t>{0});
}

TEST(InFlight, CountsADeathAgainstWhatItsWorkerWasAtWorkOnAlone) {
  InFlight flight({.ahead = 2});
  const RequestId request = begin(flight, 4);
  flight.add_worker(kAnn, 2);
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
  }
  EXPECT_EQ(flight.lose_worker(kAnn, LossCause::died).suspect, 2U);
  EXPECT_EQ(flight.deaths({request, 1}), 1U);
  EXPECT_EQ(flight.deaths({request, 2}), 0U) << "it waited for a lane";
}

// A whole fleet that goes out of reach proves nothing against the unit that went from one of them to the next.
TEST(InFlight, CountsNoDeathWhenWorkersGoOutOfReachInTurn) {
  for (std::uint64_t workers = 1; workers <= 64; ++workers) {
    InFlight flight({.lost_before_apart = 8});
    const RequestId request = begin(flight, 1);
    std::uint32_t apart = 0;
    for (std::uint64_t worker = 1; worker <= workers; ++worker) {
      flight.add_worker(WorkerId{worker});
      if (apart == 0) {
        ASSERT_TRUE(flight.offer(WorkerId{worker}, 1, kStart, {.patience = 1s}));
      }
      apart += flight.lose_worker(WorkerId{worker}, LossCause::unreachable).apart;
    }
    EXPECT_EQ(flight.deaths({request, 0}), 0U);
    EXPECT_EQ(apart, workers >= 8 ? 1U : 0U) << workers << ": the coordinator computes it, once";
    EXPECT_EQ(flight.unsettled(), 1U) << workers;
  }
}

// While other requests would fill all workers up again and again, one of them is kept for a unit that travels alone.
TEST(InFlight, LetsNoIsolatedUnitStarveBehindOtherRequests) {
  InFlight flight({.ahead = 1, .isolate_after = 1});
  const RequestId deadly = begin(flight, 1);
  flight.add_worker(kAnn);
  flight.offer(kAnn, 1, kStart, {.patience = 1s});
  begin(flight, 1'000'000);
  flight.add_worker(kBen);
  std::deque<Batch> of_ben;
  while (const auto batch = flight.offer(kBen, 10, kStart, {.patience = 1s})) {
    of_ben.push_back(*batch);
  }
  flight.lose_worker(kAnn, LossCause::died);
  ASSERT_TRUE(flight.isolated_waits());
  bool sent = false;
  for (int i = 0; i < 10 && !sent; ++i) {
    flight.settle(of_ben.front().id, kBen, kStart);
    of_ben.pop_front();
    flight.keep_one_free({{kBen, 1ms}});
    while (const auto batch = flight.offer(kBen, 10, kStart, {.patience = 1s})) {
      of_ben.push_back(*batch);
      sent = sent || batch->request == deadly;
    }
  }
  EXPECT_TRUE(sent);
}

TEST(InFlight, KeepsUnitsForTheCoordinatorItself) {
  InFlight flight = two_workers();
  const RequestId request = begin(flight, 10);
  const auto home = flight.offer_home(request, 4, kStart);
  ASSERT_TRUE(home);
  EXPECT_EQ(home->count, 4U);
  EXPECT_EQ(flight.waiting(), 6U);
  EXPECT_FALSE(flight.next_due()) << "home keeps its word";
  EXPECT_EQ(flight.settle(home->id, kHome, kStart).fresh.size(), 4U);
  flight.close(request);
  EXPECT_TRUE(flight.done());
}

TEST(InFlight, ClearsTheUnitsOfALostWorkerThatComesBack) {
  InFlight flight({.ahead = 0, .lost_before_apart = 2});
  begin(flight, 1);
  for (int glitch = 0; glitch < 10; ++glitch) {
    flight.add_worker(kAnn);
    ASSERT_TRUE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
    ASSERT_EQ(flight.lose_worker(kAnn, LossCause::unreachable).apart, 0U);
  }
  EXPECT_EQ(flight.unsettled(), 1U);
}

TEST(InFlight, KeepsEveryLaneOfAWorkerBusyAndOneBatchAhead) {
  InFlight flight({.ahead = 1});
  flight.add_worker(kAnn, 4);
  begin(flight, 100);
  int batches = 0;
  while (flight.offer(kAnn, 1, kStart, {.patience = 1s})) {
    ++batches;
  }
  EXPECT_EQ(batches, 5);
}

TEST(InFlight, CopiesNothingThatIsSettledAndNoCopies) {
  InFlight flight({.ahead = 0, .copies = 5});
  for (std::uint64_t w = 1; w <= 4; ++w) {
    flight.add_worker(WorkerId{w});
  }
  begin(flight, 2);
  flight.offer(WorkerId{1}, 1, kStart, {.patience = 1s});
  flight.offer(WorkerId{2}, 1, kStart, {.patience = 9s});
  const auto copy = flight.offer_copy(WorkerId{3}, kStart + 1s, {.patience = 1s});
  ASSERT_TRUE(copy);
  flight.settle(copy->id, WorkerId{3}, kStart);
  EXPECT_FALSE(flight.offer_copy(WorkerId{4}, kStart + 5s, {.patience = 1s}));  // unit 0 is settled, unit 1 not overdue
  EXPECT_EQ(flight.next_due(), kStart + 9s);
}

TEST(InFlight, DoesNotSuspectTheUnitsOfAWorkerThatLeft) {
  InFlight flight({.ahead = 0, .isolate_after = 1, .apart_after = 2, .lost_before_apart = 2});
  begin(flight, 1);
  for (std::uint64_t w = 1; w <= 10; ++w) {
    flight.add_worker(WorkerId{w});
    ASSERT_TRUE(flight.offer(WorkerId{w}, 1, kStart, {.patience = 1s}));
    EXPECT_EQ(flight.lose_worker(WorkerId{w}, LossCause::left).apart, 0U);
  }
  EXPECT_EQ(flight.unsettled(), 1U);
}

TEST(InFlight, AbandonsARequestAndStartsTheNext) {
  InFlight flight = two_workers({.ahead = 0});
  const RequestId given_up = begin(flight, 3);
  const auto old = flight.offer(kAnn, 3, kStart, {.patience = 1s});
  flight.close(given_up);
  EXPECT_TRUE(flight.done());
  begin(flight, 2);
  EXPECT_EQ(flight.settle(old->id, kAnn, kStart).kind, Settled::duplicate);
  EXPECT_EQ(flight.unsettled(), 2U);
}

TEST(InFlight, ServesSeveralRequestsInOrderAndSettlesEachByItself) {
  InFlight flight = two_workers();
  const RequestId first = begin(flight, 3);
  const RequestId second = begin(flight, 2);
  EXPECT_EQ(flight.front(), first);
  const auto a = flight.offer(kAnn, 9, kStart, {.patience = 1s});
  ASSERT_TRUE(a);
  EXPECT_EQ(a->count, 3U);  // no batch spans two
  EXPECT_EQ(flight.front(), second);
  const auto b = flight.offer(kBen, 9, kStart, {.patience = 1s});
  ASSERT_TRUE(b);
  EXPECT_EQ(b->request, second);
  EXPECT_EQ(b->first, 0U);
  EXPECT_EQ(b->count, 2U);
  flight.settle(b->id, kBen, kStart);
  EXPECT_TRUE(flight.done(second));
  EXPECT_FALSE(flight.done(first));
  flight.close(second);
  const auto loss = flight.lose_worker(kAnn, LossCause::died);
  EXPECT_EQ(loss.batches, 1U);
  EXPECT_EQ(flight.front(), first);
  EXPECT_EQ(flight.waiting(), 3U);
  flight.close(first);
  EXPECT_TRUE(flight.done());
  EXPECT_EQ(flight.waiting(), 0U);
  EXPECT_EQ(flight.settle(a->id, kAnn, kStart).kind, Settled::foreign);
}

// Whatever happens, in any order, to several requests at once: every unit is settled exactly once and nothing is
// lost.
TEST(InFlight, SettlesEveryUnitExactlyOnceUnderRandomFaults) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Xoshiro256 random(seed);
    InFlight flight({.ahead = random.below(3),
                     .isolate_after = 1 + static_cast<std::uint32_t>(random.below(4)),
                     .apart_after = 4 + static_cast<std::uint32_t>(random.below(4)),
                     .lost_before_apart = 4 + static_cast<std::uint32_t>(random.below(4))});
    std::set<WorkerId> alive;
    std::vector<std::pair<BatchId, WorkerId>> out;
    std::uint64_t next_worker = 1;
    InFlight::Time now = kStart;
    std::map<RequestId, std::vector<int>> settled;
    for (int begun = 0, event = 0; begun < 6 || !flight.done(); ++event) {
      ASSERT_LT(event, 100'000) << "seed " << seed << ": stuck";
      now += 100ms;
      if (begun < 6 && (flight.done() || random.below(20) == 0)) {
        const auto units = static_cast<std::uint32_t>(1 + random.below(60));
        settled.emplace(begin(flight, units), std::vector<int>(units, 0));
        ++begun;
      }
      const std::uint64_t kind = random.below(100);
      if (alive.empty() || kind < 4) {
        const WorkerId worker{next_worker++};
        alive.insert(worker);
        flight.add_worker(worker, 1 + random.below(3));
        continue;
      }
      const WorkerId worker = *std::next(alive.begin(), static_cast<std::ptrdiff_t>(random.below(alive.size())));
      if (kind < 6) {
        flight.lose_worker(worker, static_cast<LossCause>(random.below(3)));
        alive.erase(worker);  // its answers may still come
      } else if (kind < 50) {
        if (const auto apart = flight.offer_apart(now)) {
          out.emplace_back(apart->id, kHome);
        } else if (const auto batch =
                       flight.offer(worker, 1 + static_cast<std::uint32_t>(random.below(20)), now, {.patience = 1s})) {
          out.emplace_back(batch->id, worker);
        } else if (const auto copy = flight.offer_copy(worker, now, {.patience = 1s})) {
          out.emplace_back(copy->id, worker);
        }
      } else if (!out.empty()) {
        const std::size_t pick = random.below(out.size());
        const auto [batch, from] = out[pick];
        if (kind < 55 && from != kHome) {
          flight.give_back(batch, from);
        } else {
          const auto settlement = flight.settle(batch, from, now);
          for (const std::uint32_t unit : settlement.fresh) {
            ++settled.at(settlement.batch.request)[unit];
          }
          if (!settlement.fresh.empty() && flight.done(settlement.batch.request) && random.below(2) == 0) {
            flight.close(settlement.batch.request);
          }
        }
        out.erase(out.begin() + static_cast<std::ptrdiff_t>(pick));
      }
    }
    for (const auto& [id, counts] : settled) {
      EXPECT_TRUE(std::all_of(counts.begin(), counts.end(), [](int count) { return count == 1; })) << "seed " << seed;
    }
  }
}

TEST(InFlight, CopiesWhatAnIdleWorkerWouldHaveDoneLongBefore) {
  InFlight flight = two_workers();
  begin(flight, 3);
  const auto slow = flight.offer(kAnn, 2, kStart, {.patience = 1s, .each = 20ms});
  const auto quick = flight.offer(kBen, 1, kStart, {.patience = 1s, .each = 2ms});
  ASSERT_TRUE(slow && quick);
  flight.settle(quick->id, kBen, kStart);
  const auto copy = flight.offer_copy(kBen, kStart + 2ms, {.patience = 1s, .each = 2ms});
  ASSERT_TRUE(copy);  // 4 ms of work against 38 ms
  EXPECT_EQ(copy->first, slow->first);
  EXPECT_EQ(copy->count, 2U);
  EXPECT_EQ(flight.settle(copy->id, kBen, kStart).fresh.size(), 2U);
  EXPECT_TRUE(flight.done());
}

TEST(InFlight, CopiesNothingThatWouldNotBeDoneInHalfTheTime) {
  InFlight flight = two_workers();
  begin(flight, 3);
  flight.offer(kAnn, 2, kStart, {.patience = 1s, .each = 2ms});
  const auto quick = flight.offer(kBen, 1, kStart, {.patience = 1s, .each = 2ms});
  flight.settle(quick->id, kBen, kStart);
  EXPECT_FALSE(flight.offer_copy(kBen, kStart + 1ms, {.patience = 1s, .each = 1ms}));  // 2 ms against 3 ms
  EXPECT_FALSE(flight.offer_copy(kBen, kStart + 1ms, {.patience = 1s}));               // not known
  EXPECT_TRUE(flight.offer_copy(kBen, kStart + 1s, {.patience = 1s}));                 // overdue
}

TEST(InFlight, CopiesWhatAWorkerOfUnknownPaceHoldsForLong) {
  InFlight flight = two_workers();
  begin(flight, 1);
  flight.offer(kAnn, 1, kStart, {.patience = 9s});
  EXPECT_FALSE(flight.offer_copy(kBen, kStart + 49ms, {.patience = 1s, .each = 1ms}));
  EXPECT_FALSE(flight.offer_copy(kBen, kStart + 50ms, {.patience = 1s, .each = 20ms}));
  EXPECT_TRUE(flight.offer_copy(kBen, kStart + 50ms, {.patience = 1s, .each = 1ms}));
}

TEST(InFlight, DoesNotCopyTheSameBatchTwiceBeforeTheCopyIsOverdue) {
  InFlight flight({.ahead = 0});
  for (std::uint64_t w = 1; w <= 3; ++w) {
    flight.add_worker(WorkerId{w});
  }
  begin(flight, 1);
  flight.offer(WorkerId{1}, 1, kStart, {.patience = 1s, .each = 1s});
  EXPECT_TRUE(flight.offer_copy(WorkerId{2}, kStart + 1ms, {.patience = 100ms, .each = 1ms}));
  EXPECT_FALSE(flight.offer_copy(WorkerId{3}, kStart + 2ms, {.patience = 100ms, .each = 1ms}));
  EXPECT_TRUE(flight.offer_copy(WorkerId{3}, kStart + 1s, {.patience = 100ms, .each = 1ms}));
}

TEST(InFlight, KnowsTheBacklogAndWhoIsLate) {
  InFlight flight = two_workers();
  begin(flight, 5);
  const auto first = flight.offer(kAnn, 3, kStart, {.patience = 1s});
  flight.offer(kBen, 2, kStart, {.patience = 2s});
  EXPECT_EQ(flight.backlog(kAnn), 3U);
  EXPECT_EQ(flight.late(kStart + 1s), std::set<WorkerId>{kAnn});
  flight.settle(first->id, kAnn, kStart);
  EXPECT_EQ(flight.backlog(kAnn), 0U);
  EXPECT_TRUE(flight.late(kStart + 1s).empty());
}

}  // namespace
}  // namespace coppice
