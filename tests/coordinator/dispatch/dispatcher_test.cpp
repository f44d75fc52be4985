// The dispatcher as a play: events at times that the test says, actions compared.
#include "coordinator/dispatch/dispatcher.hpp"

#include <algorithm>
#include <functional>
#include <gtest/gtest.h>
#include <set>

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kProtocol = 3;
constexpr std::uint64_t kGolden = 77;

Origin origin_of(std::uint64_t participant) {
  Origin origin{};
  std::copy_n(reinterpret_cast<const std::uint8_t*>(&participant), sizeof participant, origin.begin());
  return origin;
}

// What a unit's pure function gives in this play.
UnitOutcome truth_of(const Unit& unit) {
  Tally tally;
  tally.steps = 1000 * static_cast<std::uint64_t>(unit.request) + unit.index;
  return tally;
}

UnitOutcome lie_of(const Unit& unit) {
  Tally tally = std::get<Tally>(truth_of(unit));
  ++tally.matches;
  return tally;
}

class Dispatching : public ::testing::Test {
 protected:
  Dispatcher& start(DispatchSettings settings = {}) {
    settings.protocol = kProtocol;
    settings.golden = kGolden;
    dispatcher_.emplace(settings);
    return *dispatcher_;
  }

  // One step with these events; what it wants done is kept, and what it computes here is answered at once.
  void step(std::vector<DispatchEvent> events = {}) {
    while (true) {
      Actions actions = dispatcher_->step(events, now_);
      events.clear();
      failure_ = actions.failure ? actions.failure : failure_;
      wake_at_ = actions.wake_at;
      for (Action& action : actions.actions) {
        if (auto* compute = std::get_if<Compute>(&action)) {
          computes_.push_back(*compute);
          if (!compute->apart) {
            events.emplace_back(computed(*compute));
          }
        } else if (auto* say = std::get_if<Say>(&action)) {
          said_ += say->text + "\n";
        } else if (auto* task = std::get_if<SendTask>(&action)) {
          tasks_.push_back(*task);
        } else {
          rest_.push_back(action);
        }
      }
      if (events.empty()) {
        return;
      }
    }
  }

  static Computed computed(const Compute& compute) {
    Computed result{compute.id, 1us, {}, {}};
    for (const std::uint32_t unit : compute.units) {
      result.outcomes.push_back(truth_of({compute.request, unit}));
    }
    return result;
  }

  void pass(std::chrono::milliseconds time, const std::vector<std::uint64_t>& alive = {}) {
    for (const auto end = now_ + time; now_ < end;) {
      now_ += 50ms;
      std::vector<DispatchEvent> events;
      for (const std::uint64_t worker : alive) {
        events.emplace_back(hello(worker));
      }
      step(std::move(events));
    }
  }

  HelloHeard hello(std::uint64_t worker) const {
    HelloHeard heard;
    heard.worker = WorkerId{worker};
    heard.origin = origin_of(worker);
    heard.name = "host, pid " + std::to_string(worker);
    heard.protocol = kProtocol;
    heard.golden = kGolden;
    heard.pid = static_cast<pid_t>(worker);
    heard.here = true;
    heard.serves = true;
    heard.holds_chain = true;
    return heard;
  }

  void come(std::uint64_t worker) { step({hello(worker), LinkChanged{WorkerId{worker}, true}}); }

  RequestId request(std::uint32_t units) {
    const RequestId id = dispatcher_->open({.work = {}, .most_per_batch = 1000, .expected = units}, now_);
    dispatcher_->add(id, units);
    dispatcher_->seal(id);
    return id;
  }

  AnswerHeard answer(const SendTask& task, const std::function<UnitOutcome(const Unit&)>& outcome = truth_of) const {
    AnswerHeard heard;
    heard.worker = task.worker;
    heard.origin = origin_of(static_cast<std::uint64_t>(task.worker));
    heard.batch = task.batch.id;
    heard.elapsed = 1ms;
    for (std::uint32_t i = 0; i < task.batch.count; ++i) {
      heard.outcomes.push_back(outcome({task.batch.request, task.batch.first + i}));
    }
    return heard;
  }

  // Every task that is sent is answered, until nothing more is.
  void answer_all(const std::function<UnitOutcome(const Unit&)>& outcome = truth_of) {
    while (!tasks_.empty()) {
      const SendTask task = tasks_.front();
      tasks_.erase(tasks_.begin());
      step({answer(task, outcome)});
    }
  }

  void expect_truth(RequestId id) {
    ASSERT_TRUE(dispatcher_->done(id));
    const auto finished = dispatcher_->take(id);
    for (std::uint32_t unit = 0; unit < finished.outcomes.size(); ++unit) {
      EXPECT_EQ(finished.outcomes[unit], truth_of({id, unit})) << unit;
    }
  }

  DispatchStatistics statistics() const { return dispatcher_->statistics(); }

  std::optional<Dispatcher> dispatcher_;
  Dispatcher::Time now_{};
  Dispatcher::Time wake_at_{};
  std::optional<Failure> failure_;
  std::vector<SendTask> tasks_;
  std::vector<Compute> computes_;
  std::vector<Action> rest_;
  std::string said_;
};

TEST_F(Dispatching, GivesTheOutcomesOfWhatWorkersAnswered) {
  start();
  const RequestId id = request(100);
  come(1);
  come(2);
  answer_all();
  expect_truth(id);
  EXPECT_EQ(statistics().workers_alive, 2U);
}

TEST_F(Dispatching, ServesRequestsThatGrowWhileTheyAreOpen) {
  start();
  come(1);
  const RequestId id = dispatcher_->open({.work = {}, .most_per_batch = 10, .expected = 20}, now_);
  dispatcher_->add(id, 12);
  step();
  answer_all();
  EXPECT_FALSE(dispatcher_->done(id));
  dispatcher_->add(id, 3);
  dispatcher_->seal(id);
  step();
  answer_all();
  expect_truth(id);
}

TEST_F(Dispatching, InventsNothingWhenAWholeFleetGoesOutOfReach) {
  for (const std::uint64_t workers : {3U, 5U, 8U, 64U}) {
    start();
    tasks_.clear();
    computes_.clear();
    for (std::uint64_t worker = 1; worker <= workers; ++worker) {
      come(worker);
    }
    const RequestId id = request(1);
    pass(100ms);
    // One after another falls silent, whoever holds the unit first.
    std::set<std::uint64_t> alive;
    for (std::uint64_t worker = 1; worker <= workers; ++worker) {
      alive.insert(worker);
    }
    while (!alive.empty() && computes_.empty()) {
      ASSERT_FALSE(tasks_.empty());
      const auto holder = static_cast<std::uint64_t>(tasks_.back().worker);
      alive.erase(alive.count(holder) != 0 ? holder : *alive.begin());
      pass(2200ms, {alive.begin(), alive.end()});
    }
    EXPECT_FALSE(dispatcher_->done(id)) << workers;
    EXPECT_EQ(statistics().suspect, 0U) << "nobody is known to have died";
    if (!computes_.empty()) {
      EXPECT_TRUE(computes_.back().apart);
      step({computed(computes_.back())});
    } else {
      come(1000);
      answer_all();
    }
    expect_truth(id);
  }
}

TEST_F(Dispatching, ComputesApartWhatItsOwnProcessesDiedOf) {
  start({.places = 3});
  for (std::uint64_t worker = 1; worker <= 3; ++worker) {
    come(worker);
  }
  const RequestId id = request(1);
  step();
  for (std::uint64_t death = 1; death <= 3; ++death) {
    ASSERT_FALSE(tasks_.empty());
    const auto holder = static_cast<std::uint64_t>(tasks_.back().worker);
    tasks_.clear();
    step({ProcessEnded{holder - 1, static_cast<pid_t>(holder), false, "was killed by signal 11"}});
    EXPECT_EQ(statistics().suspect, death);
  }
  EXPECT_TRUE(tasks_.empty());
  ASSERT_EQ(computes_.size(), 1U);
  EXPECT_TRUE(computes_.front().apart);
  step({computed(computes_.front())});
  expect_truth(id);
  EXPECT_EQ(statistics().apart, 1U);
  EXPECT_EQ(std::count_if(rest_.begin(), rest_.end(),
                          [](const Action& action) { return std::holds_alternative<StartProcess>(action); }),
            3);
}

TEST_F(Dispatching, StopsNamingTheUnitWhenTheProcessApartDiesToo) {
  start({.limits = {.apart_after = 1}, .places = 1});
  come(1);
  const RequestId id = request(7);
  step();
  ASSERT_FALSE(tasks_.empty());
  const std::uint32_t first = tasks_.front().batch.first;
  step({ProcessEnded{0, 1, false, "was killed by signal 11"}});
  ASSERT_FALSE(computes_.empty());
  step({Computed{computes_.front().id, 1s, {}, "process 9 was killed by signal 11"}});
  ASSERT_TRUE(failure_);
  EXPECT_EQ(failure_->deadly, (Unit{id, first}));
  EXPECT_EQ(failure_->error.kind, ErrorKind::failed);
  EXPECT_NE(failure_->error.message.find("1 worker process ended"), std::string::npos) << failure_->error.message;
}

TEST_F(Dispatching, TakesAProcessOfAnotherHostForNoneOfItsOwn) {
  start({.places = 1});
  HelloHeard elsewhere = hello(1);
  elsewhere.here = false;
  step({elsewhere, LinkChanged{WorkerId{1}, true}});
  step({ProcessEnded{0, 1, false, "was killed by signal 9"}});
  EXPECT_EQ(statistics().workers_lost, 0U);
}

// A slot of an abandoned request may be out at workers that die later, whatever was suspected of it.
TEST_F(Dispatching, ForgetsSuspicionsWithTheRequestsThatWereAbandoned) {
  start({.limits = {.apart_after = 1}, .places = 2});
  come(1);
  come(2);
  request(2);
  step();
  ASSERT_EQ(tasks_.size(), 2U);
  step({ProcessEnded{0, 1, false, "was killed by signal 9"}});
  dispatcher_->abandon();
  step({ProcessEnded{1, 2, false, "was killed by signal 9"}, Computed{ComputeId{1}, 1us, {truth_of({})}, {}}});
  come(3);
  tasks_.clear();
  const RequestId id = request(3);
  step();
  answer_all();
  expect_truth(id);
}

TEST_F(Dispatching, LetsNobodySayFarewellInAWorkersName) {
  start();
  come(1);
  HelloHeard cause = hello(1);
  cause.leaving = true;
  cause.origin = origin_of(99);
  step({cause});
  cause.origin.reset();  // its writer is gone
  step({cause});
  EXPECT_EQ(statistics().workers_alive, 1U);
  EXPECT_EQ(statistics().rejected, 2U);
  cause.origin = origin_of(1);
  step({cause});
  EXPECT_EQ(statistics().workers_alive, 0U);
  EXPECT_EQ(statistics().workers_lost, 0U) << "it left in order";
}

TEST_F(Dispatching, LetsNobodyKeepAWorkerAliveWithHellosInItsName) {
  start();
  come(1);
  HelloHeard forged = hello(1);
  forged.origin = origin_of(99);
  for (int i = 0; i < 60; ++i) {
    now_ += 50ms;
    step({forged});
  }
  EXPECT_EQ(statistics().workers_lost, 1U);
  EXPECT_EQ(statistics().workers_alive, 0U) << "nor takes the name over";
  step({hello(1), LinkChanged{WorkerId{1}, true}});
  EXPECT_EQ(statistics().workers_alive, 1U) << "its owner is welcome";
}

TEST_F(Dispatching, DoesNotTakeItsOwnAbsenceForTheirs) {
  start();
  come(1);
  now_ += 1h;  // the coordinator was stopped, and goes on before anything has come in
  step();
  pass(1s);
  EXPECT_EQ(statistics().workers_lost, 0U);
  pass(2s);
  EXPECT_EQ(statistics().workers_lost, 1U) << "still nothing";
}

TEST_F(Dispatching, RefusesABuildThatComputesOtherwise) {
  start();
  HelloHeard other = hello(1);
  other.golden = kGolden + 1;
  other.version = "1.0";
  step({other, other});
  EXPECT_TRUE(dispatcher_->roster().all().empty());
  EXPECT_NE(said_.find("refused the worker host, pid 1 (version 1.0): it computes otherwise"), std::string::npos)
      << said_;
  EXPECT_EQ(said_.find("refused the worker", said_.find("refused the worker") + 1), std::string::npos) << "said once";
}

TEST_F(Dispatching, FindsALiarByTheFirstAnswerAndCountsNothingOfIt) {
  start({.cross_check = 1e-9, .seed = 3});
  come(1);
  const RequestId id = request(50);
  step();
  answer_all(lie_of);
  EXPECT_EQ(statistics().quarantined, 1U);
  EXPECT_FALSE(failure_);
  come(2);
  answer_all();
  expect_truth(id);
  come(1);
  EXPECT_EQ(statistics().workers_alive, 1U) << "not heard any more";
}

TEST_F(Dispatching, DoesAgainWhatALateLiarSaidAndRevokesWhatItHandedOut) {
  start({.cross_check = 0.0});
  come(1);
  come(2);
  const RequestId first = request(2);
  step();
  answer_all();
  dispatcher_->take(first);
  // 1 lies now, and 2 answers the same unit: the coordinator finds out who is right.
  const RequestId second = request(1);
  step();
  ASSERT_EQ(tasks_.size(), 1U);
  const SendTask original = tasks_.front();
  tasks_.clear();
  pass(5s, {1, 2});
  ASSERT_FALSE(tasks_.empty()) << "a copy of what is late";
  const SendTask copy = tasks_.front();
  request(1);  // so that the liar's is not the last that is open
  step({answer(original, lie_of), answer(copy)});
  EXPECT_EQ(statistics().quarantined, 1U);
  EXPECT_GE(statistics().compared, 1U);
  EXPECT_EQ(statistics().cross_checked, 1U);
  expect_truth(second);
}

TEST_F(Dispatching, FailsAsRevokedWhenEarlierResultsRestOnALiar) {
  start({.cross_check = 0.0});
  come(1);
  const RequestId first = request(4);
  step();
  answer_all(lie_of);
  dispatcher_->take(first);
  come(2);
  const RequestId second = request(1);
  step();
  const SendTask original = tasks_.front();
  tasks_.clear();
  pass(5s, {1, 2});
  ASSERT_FALSE(tasks_.empty());
  const SendTask copy = tasks_.front();
  const bool liar_has_the_original = original.worker == WorkerId{1};
  step({answer(original, liar_has_the_original ? lie_of : truth_of)});
  EXPECT_FALSE(failure_);
  Actions actions;
  std::vector<DispatchEvent> events = {answer(copy, liar_has_the_original ? truth_of : lie_of)};
  actions = dispatcher_->step(events, now_);
  ASSERT_FALSE(dispatcher_->done(second)) << "in dispute";
  const auto compute = std::find_if(actions.actions.begin(), actions.actions.end(),
                                    [](const Action& action) { return std::holds_alternative<Compute>(action); });
  ASSERT_NE(compute, actions.actions.end());
  step({computed(std::get<Compute>(*compute))});
  EXPECT_EQ(statistics().quarantined, 1U);
  EXPECT_EQ(dispatcher_->roster().find(WorkerId{1}), nullptr);
}

TEST_F(Dispatching, BansWhoSendsDamagedAnswers) {
  start();
  come(1);
  const RequestId id = request(3);
  step();
  AnswerHeard damaged = answer(tasks_.front());
  damaged.kind = AnswerHeard::Kind::damaged;
  damaged.text = "an answer to another batch";
  tasks_.clear();
  step({damaged});
  EXPECT_EQ(statistics().workers_alive, 0U);
  EXPECT_EQ(statistics().rejected, 1U);
  come(2);
  answer_all();
  expect_truth(id);
}

TEST_F(Dispatching, IsDoneOnlyWhenEverySampleWasLookedAt) {
  start({.cross_check = 1.0});
  come(1);
  const RequestId id = request(1);
  step();
  std::vector<DispatchEvent> events = {answer(tasks_.front())};
  const Actions actions = dispatcher_->step(events, now_);
  EXPECT_FALSE(dispatcher_->done(id));
  ASSERT_EQ(actions.actions.size(), 1U);
  step({computed(std::get<Compute>(actions.actions.front()))});
  expect_truth(id);
}

TEST_F(Dispatching, StartsAProcessAgainSoManyTimesInARow) {
  start({.places = 1});
  request(1);
  for (int i = 0; i <= Dispatcher::kMaxRestarts; ++i) {
    EXPECT_EQ(dispatcher_->processes(), 1U);
    step({ProcessEnded{0, static_cast<pid_t>(100 + i), false, "worker process exited with code 1"}});
  }
  EXPECT_EQ(dispatcher_->processes(), 0U);
  EXPECT_EQ(rest_.size(), static_cast<std::size_t>(Dispatcher::kMaxRestarts));
  pass(100ms);
  ASSERT_TRUE(failure_);
  EXPECT_NE(failure_->error.message.find("all worker processes ended"), std::string::npos);
}

TEST_F(Dispatching, FailsAfterTheWaitLimitWhenNobodyComes) {
  start({.wait_limit = 1s});
  request(1);
  pass(900ms);
  EXPECT_FALSE(failure_);
  pass(300ms);
  ASSERT_TRUE(failure_);
  EXPECT_NE(failure_->error.message.find("no worker within 1 s"), std::string::npos) << failure_->error.message;
}

TEST_F(Dispatching, GivesAWorkerThatComesLateItsTime) {
  start({.wait_limit = 1s});
  const RequestId id = request(1);
  pass(900ms);
  come(1);
  pass(500ms, {1});
  EXPECT_FALSE(failure_) << failure_->error.message;
  answer_all();
  expect_truth(id);
}

TEST_F(Dispatching, FreesTheCreditOfAnswersToClosedRequests) {
  start({.limits = {.ahead = 0}});
  come(1);
  request(1);
  step();
  ASSERT_EQ(tasks_.size(), 1U);
  const SendTask late = tasks_.front();
  dispatcher_->abandon();
  tasks_.clear();
  const RequestId id = request(1);
  step();
  EXPECT_TRUE(tasks_.empty()) << "at work on what nobody waits for";
  step({answer(late)});
  answer_all();
  expect_truth(id);
  EXPECT_EQ(statistics().duplicates, 1U);
}

// Whoever is a little sooner done than others has nothing to do for a moment; what they are at is not overdue.
TEST_F(Dispatching, CopiesNothingWhileAllKeepTheirPace) {
  constexpr std::uint64_t kWorkers = 32;
  start();
  for (std::uint64_t worker = 1; worker <= kWorkers; ++worker) {
    come(worker);
  }
  for (int epoch = 0; epoch < 30; ++epoch) {
    std::vector<RequestId> demes;
    for (std::uint64_t deme = 0; deme < kWorkers; ++deme) {
      demes.push_back(request(1));
      step();
    }
    ASSERT_EQ(tasks_.size(), kWorkers);
    for (const auto until_next : {46ms, 4ms}) {
      now_ += until_next;
      for (std::uint64_t task = 0; task < kWorkers / 2; ++task) {
        AnswerHeard done = answer(tasks_.front());
        done.elapsed = 50ms;
        tasks_.erase(tasks_.begin());
        step({std::move(done), hello(1 + task), hello(1 + kWorkers / 2 + task)});
      }
    }
    for (const RequestId deme : demes) {
      expect_truth(deme);
    }
  }
  EXPECT_EQ(statistics().copies, 0U);
}

TEST_F(Dispatching, KnowsWhoWasOvertakenAsSlow) {
  start();
  come(1);
  come(2);
  const auto take_at = [&](std::chrono::milliseconds elapsed) {
    const SendTask task = tasks_.front();
    tasks_.erase(tasks_.begin());
    AnswerHeard done = answer(task);
    done.elapsed = elapsed;
    return done;
  };
  const RequestId first = request(1);
  step();
  const RequestId second = request(1);
  step();
  ASSERT_EQ(tasks_.size(), 2U);
  ASSERT_EQ(tasks_.front().worker, WorkerId{1});
  const AnswerHeard late = take_at(1000ms);
  pass(50ms, {1, 2});
  step({take_at(50ms)});
  expect_truth(second);
  pass(300ms, {1, 2});
  ASSERT_EQ(tasks_.size(), 1U);  // a copy of what the first is at
  pass(50ms, {1, 2});
  step({take_at(50ms)});
  expect_truth(first);
  pass(600ms, {1, 2});
  step({late});
  request(1);
  step();
  ASSERT_EQ(tasks_.size(), 1U);
  EXPECT_EQ(tasks_.front().worker, WorkerId{2});
}

TEST_F(Dispatching, WakesInTimeForWhatBecomesOverdue) {
  start();
  come(1);
  request(1);
  step();
  EXPECT_LE(wake_at_, now_ + 100ms);
  EXPECT_GT(wake_at_, now_);
}

}  // namespace
}  // namespace coppice
