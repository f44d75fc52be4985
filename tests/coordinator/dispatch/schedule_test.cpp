// Requests played through on a clock of the test's own: paces are exact, the way there and back takes a fixed time.
#include "coordinator/dispatch/schedule.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <optional>

namespace coppice {
namespace {

using namespace std::chrono_literals;
using Time = InFlight::Time;
using Duration = InFlight::Duration;

constexpr std::uint32_t kMost = 10'000;
constexpr int kMostEvents = 1'000'000;

class Play {
 public:
  struct Worker {
    Duration each{};          // what an individual takes
    bool measured = false;    // known to the coordinator
    bool stopped = false;     // takes batches and never answers
    std::vector<Batch> held;  // in the order of coming
    Time free{};
  };

  explicit Play(std::vector<Duration> paces) {
    for (std::size_t i = 0; i < paces.size(); ++i) {
      workers_.emplace_back();
      workers_.back().each = paces[i];
      flight_.add_worker(WorkerId{i + 1});
    }
  }

  Worker& worker(std::size_t index) { return workers_[index]; }
  int copies() const { return copies_; }

  // How long a request takes.
  Duration request_of(std::uint32_t units) {
    const Time begin = now_;
    const RequestId request{++requests_};
    flight_.open(request, kMost);
    flight_.add(request, units);
    for (int event = 0; !flight_.done(); ++event) {
      EXPECT_LT(event, kMostEvents) << "stuck";
      if (event >= kMostEvents) {
        break;
      }
      hand_out();
      pass_time();
    }
    flight_.close(request);
    return now_ - begin;
  }

 private:
  void hand_out() {
    std::vector<ReadyWorker> ready;
    for (std::size_t i = 0; i < workers_.size(); ++i) {
      ready.push_back({WorkerId{i + 1}, {1, workers_[i].measured ? workers_[i].each : 0ns}});
    }
    for (const Assignment& assignment : next_assignments(flight_, ready, 0, now_)) {
      Worker& worker = workers_[static_cast<std::size_t>(assignment.worker) - 1];
      if (worker.held.empty()) {
        worker.free = now_ + kWay;
      }
      worker.held.push_back(assignment.batch);
      copies_ += assignment.copy ? 1 : 0;
    }
  }

  Time answer_of(const Worker& worker) const { return worker.free + worker.each * worker.held.front().count; }

  // To the next answer, or to the next time at which the coordinator would look by itself.
  void pass_time() {
    Time next = now_ + kTend;
    std::optional<std::size_t> from;
    for (std::size_t i = 0; i < workers_.size(); ++i) {
      const Worker& worker = workers_[i];
      if (!worker.stopped && !worker.held.empty() && answer_of(worker) + kWay < next) {
        next = answer_of(worker) + kWay;
        from = i;
      }
    }
    if (!from) {
      if (const auto due = flight_.next_due(); due && *due > now_ && *due < next) {
        next = *due;
      }
      now_ = next;
      return;
    }
    Worker& worker = workers_[*from];
    worker.free = answer_of(worker);
    now_ = std::max(now_, next);
    flight_.settle(worker.held.front().id, WorkerId{*from + 1}, now_);
    worker.held.erase(worker.held.begin());
    worker.measured = true;
  }

  static constexpr Duration kWay = 50us;
  static constexpr Duration kTend = 100ms;

  std::uint64_t requests_ = 0;
  InFlight flight_{InFlightLimits{}};
  std::vector<Worker> workers_;
  int copies_ = 0;
  Time now_{};
};

double ratio(Duration time, Duration ideal) {
  return static_cast<double>(time.count()) / static_cast<double>(ideal.count());
}

TEST(Schedule, KeepsWorkersOfOnePaceBusyToTheEnd) {
  for (const std::size_t workers : {1, 2, 7, 64}) {
    Play play(std::vector<Duration>(workers, 2ms));
    const auto units = static_cast<std::uint32_t>(20 * workers);
    play.request_of(units);
    EXPECT_LT(ratio(play.request_of(units), 40ms), 1.1) << workers << " workers";
  }
}

TEST(Schedule, EndsWithinAFifthOfTheIdealWithOneWorkerTenTimesSlower) {
  std::vector<Duration> paces(19, 2ms);
  paces.push_back(20ms);
  for (const std::uint32_t units : {400U, 1000U, 4000U}) {
    Play play(paces);
    const double individuals_per_ms = 19.0 / 2.0 + 1.0 / 20.0;
    const auto ideal = std::chrono::nanoseconds(static_cast<std::int64_t>(units / individuals_per_ms * 1e6));
    EXPECT_LT(ratio(play.request_of(units), ideal), 1.2) << units << " units, paces unknown";
    EXPECT_LT(ratio(play.request_of(units), ideal), 1.2) << units << " units, paces known";
  }
}

TEST(Schedule, TakesAWorkerThatSlowsDownForWhatItIs) {
  Play play(std::vector<Duration>(10, 1ms));
  play.request_of(500);
  play.worker(3).each = 50ms;  // 50 times slower, and the coordinator learns of it by answers alone
  play.request_of(500);
  EXPECT_LT(ratio(play.request_of(500), 500ms / 9), 1.2);
}

TEST(Schedule, FinishesWithoutAWorkerThatStopped) {
  Play play(std::vector<Duration>(4, 1ms));
  play.request_of(100);
  play.worker(0).stopped = true;
  play.request_of(100);
  EXPECT_GT(play.copies(), 0);
}

TEST(Schedule, FinishesWithoutAWorkerThatNeverAnswered) {
  Play play(std::vector<Duration>(3, 1ms));
  play.worker(1).stopped = true;
  play.request_of(100);
  EXPECT_GT(play.copies(), 0);
}

TEST(Schedule, FinishesWhenTheFastestStopped) {
  Play play({1us, 50ms});
  play.request_of(100);
  play.worker(0).stopped = true;
  play.request_of(10);
  EXPECT_GT(play.copies(), 0);
}

}  // namespace
}  // namespace coppice
