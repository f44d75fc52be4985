// The bookkeeping as sequences of calls; time is whatever the test says it is.
#include "coordinator/dispatch/in_flight.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "common/chain/random.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;
using Farewell = InFlight::Farewell;
using Settled = InFlight::Settled;

constexpr WorkerId kAnn{1};
constexpr WorkerId kBen{2};
constexpr InFlight::Time kStart{};

InFlight two_workers(const InFlightLimits& limits = {}) {
  InFlight flight(limits);
  flight.add_worker(kAnn);
  flight.add_worker(kBen);
  return flight;
}

TEST(InFlight, HandsOutEverySlotOnceAndIsDoneWhenAllAreSettled) {
  InFlight flight = two_workers();
  flight.begin(10);
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
  flight.begin(10);
  EXPECT_TRUE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
  const auto second = flight.offer(kAnn, 1, kStart, {.patience = 1s});
  ASSERT_TRUE(second);
  EXPECT_FALSE(flight.can_take(kAnn));
  EXPECT_FALSE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
  flight.settle(second->id, kAnn, kStart);
  EXPECT_TRUE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
}

TEST(InFlight, CountsADuplicateAndAForeignAnswerAsNothing) {
  InFlight flight = two_workers();
  flight.begin(2);
  const auto batch = flight.offer(kAnn, 2, kStart, {.patience = 1s});
  EXPECT_EQ(flight.settle(batch->id, kBen, kStart).kind, Settled::foreign);
  EXPECT_EQ(flight.settle(BatchId{99}, kAnn, kStart).kind, Settled::foreign);
  EXPECT_EQ(flight.settle(batch->id, kAnn, kStart).kind, Settled::first);
  EXPECT_EQ(flight.settle(batch->id, kAnn, kStart).kind, Settled::foreign);
  EXPECT_TRUE(flight.done());
}

TEST(InFlight, OffersALostWorkersSlotsFirst) {
  InFlight flight = two_workers();
  flight.begin(10);
  flight.offer(kAnn, 4, kStart, {.patience = 1s});
  const auto loss = flight.lose_worker(kAnn, Farewell::died);
  EXPECT_EQ(loss.batches, 1U);
  EXPECT_TRUE(loss.poisonous.empty());
  const auto again = flight.offer(kBen, 10, kStart, {.patience = 1s});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->first, 0U);
  EXPECT_EQ(again->count, 4U);
}

TEST(InFlight, TakesALateAnswerOfALostWorker) {
  InFlight flight = two_workers();
  flight.begin(4);
  const auto batch = flight.offer(kAnn, 4, kStart, {.patience = 1s});
  flight.lose_worker(kAnn, Farewell::died);
  EXPECT_EQ(flight.settle(batch->id, kAnn, kStart).fresh.size(), 4U);
  EXPECT_TRUE(flight.done());
  EXPECT_EQ(flight.waiting(), 0U);
}

TEST(InFlight, OffersACopyOfAnOverdueBatchAndTakesWhicheverAnswersFirst) {
  InFlight flight = two_workers();
  flight.begin(4);
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
  flight.begin(1);
  flight.offer(WorkerId{1}, 1, kStart, {.patience = 1s});
  EXPECT_TRUE(flight.offer_copy(WorkerId{2}, kStart + 1s, {.patience = 1s}));
  EXPECT_FALSE(flight.offer_copy(WorkerId{3}, kStart + 1s, {.patience = 1s}));
}

TEST(InFlight, ChargesLeftoversOfEarlierGenerationsToTheirWorker) {
  InFlight flight = two_workers({.ahead = 0});
  const GenerationId first = flight.begin(1);
  flight.offer(kAnn, 1, kStart, {.patience = 1s});
  const auto copy = flight.offer_copy(kBen, kStart + 1s, {.patience = 1s});
  flight.settle(copy->id, kBen, kStart);
  flight.end(first);
  flight.begin(2);
  EXPECT_FALSE(flight.can_take(kAnn));  // still at work on the old batch
  EXPECT_TRUE(flight.can_take(kBen));
}

TEST(InFlight, SendsASlotThatKilledWorkersAloneAndGivesUpAtTheLimit) {
  InFlight flight({.ahead = 1, .attempts = 4, .isolate_after = 2});
  const GenerationId generation = flight.begin(5);
  std::vector<Slot> poisonous;
  std::uint64_t next = 1;
  for (int death = 0; death < 4; ++death) {
    const WorkerId worker{next++};
    flight.add_worker(worker);
    // The worker dies with slot 0; everything else that it was given beside it is settled first.
    std::vector<Batch> held;
    while (const auto batch = flight.offer(worker, 5, kStart, {.patience = 1s})) {
      held.push_back(*batch);
    }
    ASSERT_FALSE(held.empty());
    if (death >= 2) {
      ASSERT_EQ(held.size(), 1U);  // alone
      EXPECT_EQ(held.front().count, 1U);
      EXPECT_EQ(held.front().first, 0U);
    }
    const auto loss = flight.lose_worker(worker, Farewell::died);
    poisonous.insert(poisonous.end(), loss.poisonous.begin(), loss.poisonous.end());
    // A healthy worker does the rest, and nothing but the rest.
    if (death == 1) {
      const WorkerId healthy{100};
      flight.add_worker(healthy);
      std::size_t settled = 0;
      for (int i = 0; i < 4; ++i) {
        // Slot 0 stands first and alone: the healthy worker takes it and gives it back.
        const auto batch = flight.offer(healthy, 1, kStart, {.patience = 1s});
        ASSERT_TRUE(batch);
        if (batch->first == 0) {
          break;
        }
        settled += flight.settle(batch->id, healthy, kStart).fresh.size();
      }
      flight.lose_worker(healthy, Farewell::left);
    }
  }
  EXPECT_EQ(poisonous, (std::vector<Slot>{{generation, 0}}));
}

TEST(InFlight, ClearsTheSlotsOfALostWorkerThatComesBack) {
  InFlight flight({.ahead = 0, .attempts = 2, .isolate_after = 9});
  flight.begin(1);
  for (int glitch = 0; glitch < 10; ++glitch) {
    flight.add_worker(kAnn);
    ASSERT_TRUE(flight.offer(kAnn, 1, kStart, {.patience = 1s}));
    ASSERT_TRUE(flight.lose_worker(kAnn, Farewell::died).poisonous.empty());
  }
  EXPECT_EQ(flight.unsettled(), 1U);
}

TEST(InFlight, DoesNotGiveASlotUpWhileAHealthyWorkerHoldsACopy) {
  InFlight flight = two_workers({.ahead = 0, .attempts = 1});
  flight.begin(1);
  flight.offer(kAnn, 1, kStart, {.patience = 1s});
  const auto copy = flight.offer_copy(kBen, kStart + 1s, {.patience = 1s});
  ASSERT_TRUE(copy);
  EXPECT_TRUE(flight.lose_worker(kAnn, Farewell::died).poisonous.empty());
  EXPECT_EQ(flight.settle(copy->id, kBen, kStart).fresh.size(), 1U);
}

TEST(InFlight, KeepsEveryLaneOfAWorkerBusyAndOneBatchAhead) {
  InFlight flight({.ahead = 1});
  flight.add_worker(kAnn, 4);
  flight.begin(100);
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
  flight.begin(2);
  flight.offer(WorkerId{1}, 1, kStart, {.patience = 1s});
  flight.offer(WorkerId{2}, 1, kStart, {.patience = 9s});
  const auto copy = flight.offer_copy(WorkerId{3}, kStart + 1s, {.patience = 1s});
  ASSERT_TRUE(copy);
  flight.settle(copy->id, WorkerId{3}, kStart);
  EXPECT_FALSE(flight.offer_copy(WorkerId{4}, kStart + 5s, {.patience = 1s}));  // slot 0 is settled, slot 1 not overdue
  EXPECT_EQ(flight.next_due(), kStart + 9s);
}

TEST(InFlight, DoesNotSuspectTheSlotsOfAWorkerThatLeft) {
  InFlight flight({.ahead = 0, .attempts = 2, .isolate_after = 1});
  flight.begin(1);
  for (std::uint64_t w = 1; w <= 10; ++w) {
    flight.add_worker(WorkerId{w});
    ASSERT_TRUE(flight.offer(WorkerId{w}, 1, kStart, {.patience = 1s}));
    EXPECT_TRUE(flight.lose_worker(WorkerId{w}, Farewell::left).poisonous.empty());
  }
  EXPECT_EQ(flight.unsettled(), 1U);
}

TEST(InFlight, AbandonsAGenerationAndStartsTheNext) {
  InFlight flight = two_workers({.ahead = 0});
  const GenerationId given_up = flight.begin(3);
  const auto old = flight.offer(kAnn, 3, kStart, {.patience = 1s});
  flight.end(given_up);
  EXPECT_TRUE(flight.done());
  flight.begin(2);
  EXPECT_EQ(flight.settle(old->id, kAnn, kStart).kind, Settled::duplicate);
  EXPECT_EQ(flight.unsettled(), 2U);
}

TEST(InFlight, ServesSeveralGenerationsInOrderAndSettlesEachByItself) {
  InFlight flight = two_workers();
  const GenerationId first = flight.begin(3);
  const GenerationId second = flight.begin(2);
  EXPECT_EQ(flight.front(), first);
  const auto a = flight.offer(kAnn, 9, kStart, {.patience = 1s});
  ASSERT_TRUE(a);
  EXPECT_EQ(a->count, 3U);  // no batch spans two
  EXPECT_EQ(flight.front(), second);
  const auto b = flight.offer(kBen, 9, kStart, {.patience = 1s});
  ASSERT_TRUE(b);
  EXPECT_EQ(b->generation, second);
  EXPECT_EQ(b->first, 0U);
  EXPECT_EQ(b->count, 2U);
  flight.settle(b->id, kBen, kStart);
  EXPECT_TRUE(flight.done(second));
  EXPECT_FALSE(flight.done(first));
  flight.end(second);
  const auto loss = flight.lose_worker(kAnn, Farewell::died);
  EXPECT_EQ(loss.batches, 1U);
  EXPECT_EQ(flight.front(), first);
  EXPECT_EQ(flight.waiting(), 3U);
  flight.end(first);
  EXPECT_TRUE(flight.done());
  EXPECT_EQ(flight.waiting(), 0U);
  EXPECT_EQ(flight.settle(a->id, kAnn, kStart).kind, Settled::foreign);
}

// Whatever happens, in any order, to several generations at once: every slot is settled exactly once and nothing is
// lost.
TEST(InFlight, SettlesEverySlotExactlyOnceUnderRandomFaults) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Xoshiro256 random(seed);
    InFlight flight({.ahead = random.below(3),
                     .attempts = 1'000'000,
                     .isolate_after = 1 + static_cast<std::uint32_t>(random.below(4))});
    std::set<WorkerId> alive;
    std::vector<std::pair<BatchId, WorkerId>> out;
    std::uint64_t next_worker = 1;
    InFlight::Time now = kStart;
    std::map<GenerationId, std::vector<int>> settled;
    for (int begun = 0, event = 0; begun < 6 || !flight.done(); ++event) {
      ASSERT_LT(event, 100'000) << "seed " << seed << ": stuck";
      now += 100ms;
      if (begun < 6 && (flight.done() || random.below(20) == 0)) {
        const auto slots = static_cast<std::uint32_t>(1 + random.below(60));
        settled.emplace(flight.begin(slots), std::vector<int>(slots, 0));
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
        flight.lose_worker(worker, random.below(2) == 0 ? Farewell::died : Farewell::left);
        alive.erase(worker);  // its answers may still come
      } else if (kind < 50) {
        if (const auto batch =
                flight.offer(worker, 1 + static_cast<std::uint32_t>(random.below(20)), now, {.patience = 1s})) {
          out.emplace_back(batch->id, worker);
        } else if (const auto copy = flight.offer_copy(worker, now, {.patience = 1s})) {
          out.emplace_back(copy->id, worker);
        }
      } else if (!out.empty()) {
        const std::size_t pick = random.below(out.size());
        const auto [batch, from] = out[pick];
        if (kind < 55) {
          flight.give_back(batch, from);
        } else {
          const auto settlement = flight.settle(batch, from, now);
          for (const std::uint32_t slot : settlement.fresh) {
            ++settled.at(settlement.batch.generation)[slot];
          }
          if (!settlement.fresh.empty() && flight.done(settlement.batch.generation) && random.below(2) == 0) {
            flight.end(settlement.batch.generation);
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
  flight.begin(3);
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
  flight.begin(3);
  flight.offer(kAnn, 2, kStart, {.patience = 1s, .each = 2ms});
  const auto quick = flight.offer(kBen, 1, kStart, {.patience = 1s, .each = 2ms});
  flight.settle(quick->id, kBen, kStart);
  EXPECT_FALSE(flight.offer_copy(kBen, kStart + 1ms, {.patience = 1s, .each = 1ms}));  // 2 ms against 3 ms
  EXPECT_FALSE(flight.offer_copy(kBen, kStart + 1ms, {.patience = 1s}));               // not known
  EXPECT_TRUE(flight.offer_copy(kBen, kStart + 1s, {.patience = 1s}));                 // overdue
}

TEST(InFlight, CopiesWhatAWorkerOfUnknownPaceHoldsForLong) {
  InFlight flight = two_workers();
  flight.begin(1);
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
  flight.begin(1);
  flight.offer(WorkerId{1}, 1, kStart, {.patience = 1s, .each = 1s});
  EXPECT_TRUE(flight.offer_copy(WorkerId{2}, kStart + 1ms, {.patience = 100ms, .each = 1ms}));
  EXPECT_FALSE(flight.offer_copy(WorkerId{3}, kStart + 2ms, {.patience = 100ms, .each = 1ms}));
  EXPECT_TRUE(flight.offer_copy(WorkerId{3}, kStart + 1s, {.patience = 100ms, .each = 1ms}));
}

TEST(InFlight, KnowsTheBacklogAndWhoIsLate) {
  InFlight flight = two_workers();
  flight.begin(5);
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
