// The world around a dispatcher: workers, their processes and hosts, the network, strangers, requesters, the clock. The
// dispatcher is the real one; everything else is played, from one seed, by discrete events. After every step of the
// dispatcher its invariants are held against what the world knows to be true (checks.cpp).
//
// A run has two parts: first everything in the plan happens, until the requests are done; then, if they are not, faults
// end, the workers are there and honest, and what is open must end within a limit of simulated time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <queue>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "coordinator/dispatch/dispatcher.hpp"
#include "tests/simulation/dice.hpp"
#include "tests/simulation/scenario.hpp"

namespace coppice::simulation {

// A promise that was broken. `what` starts with its name, which stays the same when the run is made smaller.
class Broken : public std::runtime_error {
 public:
  Broken(const std::string& name, const std::string& how) : std::runtime_error(name + ": " + how), name_(name) {}
  const std::string& name() const { return name_; }

 private:
  std::string name_;
};

struct Report {
  std::uint64_t requests = 0;  // done
  std::uint64_t steps = 0;
  std::uint64_t actions_hash = 0;
  Nanos simulated = 0;
  Nanos all_ready = 0;  // when every seat's worker was, for the first time
  bool stopped_by_deadly_unit = false;
};

class World {
 public:
  static constexpr std::uint32_t kProtocol = 3;

  explicit World(const Scenario& scenario);
  // Throws Broken.
  Report run();

 private:
  enum class What : std::uint8_t {
    hello_due,      // worker says Hello again
    hello,          // arrives at the coordinator
    task,           // arrives at the worker
    computed,       // a lane is done with its batch
    answer,         // arrives at the coordinator
    link,           // readers came or went
    chain,          // blocks arrived at the worker
    announced,      // the run was heard of
    process_comes,  // in a seat
    process_seen_to_end,
    home_computed,
    fault,
    fault_ends,
    client,
    wake,
  };
  struct Happening {
    Nanos at = 0;
    std::uint64_t order = 0;
    What what{};
    std::uint32_t seat = 0;
    std::uint32_t life = 0;
    std::uint64_t a = 0;
    std::uint64_t b = 0;
    std::uint32_t c = 0;
    std::uint32_t d = 0;
  };
  struct Later {
    bool operator()(const Happening& x, const Happening& y) const {
      return x.at != y.at ? x.at > y.at : x.order > y.order;
    }
  };
  struct Lane {
    std::optional<std::size_t> batch;  // its place in sent_
    std::uint64_t turn = 0;
  };
  struct Seat {
    std::uint32_t life = 0;  // of its process: a new number each time
    bool runs = false;
    bool fake = false;  // comes by a fault, and not again
    bool other_build = false;
    WorkerId id{};
    std::uint32_t place = 0;
    bool holds_chain = false;
    bool serves = false;
    std::uint64_t evaluated = 0;
    std::deque<std::size_t> queue;  // places in sent_
    std::vector<Lane> lanes;
    // Faults
    Nanos stopped_until = 0;
    Nanos cut_off_until = 0;
    Nanos slow_until = 0;
    std::uint32_t slowness = 1;
    Nanos hangs_until = 0;
    Nanos short_until = 0;
    std::uint32_t short_above = 0;
    std::uint32_t shortages = 0;  // answered since
    Nanos shortages_since = 0;
    std::uint32_t lies = 0;  // 0: no; 1: always; 2: seldom; 3: once; of a fake: 4: damages, 5: never answers
    bool lied = false;
    bool damages = false;
    bool touched = false;     // by any fault
    std::vector<Batch> sent;  // to this process, and not answered as far as the coordinator knows
    Nanos last_task_arrives = 0;
    std::uint32_t dies_in_phase = 0;  // 1: on a task; 2: in the middle; 3: before it answers
    Nanos absent_until = 0;
  };
  struct Client {
    std::optional<RequestId> request;
    std::uint32_t number = 0;  // of its requests
    std::uint32_t added = 0;   // units
    bool over = false;
    bool due = false;  // begins its next request
  };

  // Time
  void at(Nanos time, What what, std::uint32_t seat, std::uint64_t a = 0, std::uint64_t b = 0, std::uint32_t c = 0,
          std::uint32_t d = 0);
  void happen(const Happening& happening);
  static Dispatcher::Time time_of(Nanos nanos) { return Dispatcher::Time(std::chrono::nanoseconds(nanos)); }
  Nanos delay(std::uint64_t link);
  bool lost(std::uint32_t seat);
  bool cut_off(const Seat& seat) const { return seat.cut_off_until > now_ || all_cut_off_until_ > now_; }

  // Workers (world_workers.cpp)
  void come(std::uint32_t seat);
  void die(std::uint32_t seat, bool in_order);
  void say_hello(std::uint32_t seat, bool leaving = false);
  void take_task(const Happening& happening);
  void work(std::uint32_t seat);
  void finish(const Happening& happening);
  void answer(std::uint32_t seat, std::size_t batch, AnswerHeard::Kind kind, std::uint32_t lie);
  HelloHeard hello_of(const Happening& happening) const;
  void begin_fault(const Fault& fault);
  void end_all_faults();
  Origin origin_of(std::uint32_t seat, std::uint32_t life) const;
  bool deadly(const Batch& batch) const;
  bool honest(std::uint32_t seat) const { return seats_[seat].lies == 0 && !seats_[seat].fake; }

  // Coordinator
  void hear(const Happening& happening);
  void hear_answer(const Happening& happening);
  void step();
  void perform(const Action& action);
  void compute(const Compute& compute);
  void requesters();
  bool is_deme(std::uint32_t client) const { return client < std::min(scenario_.demes, scenario_.clients); }
  bool may_begin(std::uint32_t client) const;
  void begin_request(std::uint32_t client);
  void add_portion(std::uint32_t client);
  void give_up();
  void failed(const Failure& failure);

  // Of what a request is made
  bool is_epoch(RequestId request) const { return epochs_.count(request) != 0; }
  std::uint32_t units_of(RequestId request) const { return is_epoch(request) ? 1 : scenario_.units; }
  Nanos cost(RequestId request, std::size_t units) const {
    return scenario_.each * static_cast<Nanos>(units) * (is_epoch(request) ? scenario_.epoch : 1);
  }

  // Truth and promises (checks.cpp)
  UnitOutcome truth(RequestId request, std::uint32_t unit) const;
  UnitOutcome lie(RequestId request, std::uint32_t unit, WorkerId liar) const;
  void check_sent(const SendTask& task) const;
  void count_shortage(std::uint32_t seat);
  void check_isolated();
  void check_step(const DispatchStatistics& before);
  void check_taken(RequestId request, const Dispatcher::Finished& finished);
  void check_failure(const Failure& failure);
  void check_end() const;
  [[noreturn]] void broken(const char* name, const std::string& how) const { throw Broken(name, how); }

  Scenario scenario_;
  Dispatcher dispatcher_;
  Nanos now_ = 0;
  std::uint64_t order_ = 0;
  std::priority_queue<Happening, std::vector<Happening>, Later> ahead_;
  std::vector<Seat> seats_;
  std::map<WorkerId, std::uint32_t> seat_of_;  // everybody who ever was
  std::vector<Client> clients_;
  std::set<RequestId> epochs_;  // all that there ever were: the others ask for evaluations
  std::vector<DispatchEvent> inbox_;
  std::map<WorkerId, std::uint64_t> links_;  // open: number
  std::uint64_t next_link_ = 1;
  std::uint64_t drawn_ = 0;
  std::map<std::uint64_t, Compute> computing_;
  std::uint64_t last_batch_ = 0;
  std::vector<Batch> sent_;  // every batch that went out; who carries one names it by its place here

  Nanos held_up_until_ = 0;
  Nanos all_cut_off_until_ = 0;
  Nanos wake_at_ = 0;
  bool faults_over_ = false;
  Nanos faults_over_at_ = 0;
  bool deadly_to_come_ = false;
  std::optional<Unit> deadly_;
  bool deadly_everywhere_ = false;
  std::set<RequestId> open_when_faults_ended_;
  bool run_over_ = false;

  // What is true of the run so far.
  std::set<WorkerId> liars_;
  std::map<WorkerId, std::uint64_t> lies_taken_;  // handed to requesters since the last revocation
  std::map<std::pair<RequestId, std::uint32_t>, std::uint32_t> deaths_at_;  // processes that died with the unit in hand
  std::uint64_t closed_links_ = 0;
  std::uint64_t apart_done_ = 0;
  std::uint32_t isolated_before_ = 0;  // units, when so many batches had been sent
  std::size_t sent_before_ = 0;
  Report report_;
};

}  // namespace coppice::simulation
