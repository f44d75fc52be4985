// What a run of the simulation is made of, all from one seed: how many workers, requests and units, what the network
// does, and the plan of faults. A plan is a list of records, so that a failing run can be made smaller by leaving some
// out. Values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace coppice::simulation {

using Nanos = std::int64_t;
inline constexpr Nanos kMicrosecond = 1000;
inline constexpr Nanos kMillisecond = 1000 * kMicrosecond;
inline constexpr Nanos kSecond = 1000 * kMillisecond;

struct Fault {
  enum class Kind : std::uint8_t {
    crash,                // the worker's process dies, at once or in a phase of its next batch (`detail`)
    pause,                // it stops, and goes on
    slow,                 // its units take `detail` times as long
    cut_off,              // nothing passes between it and the coordinator
    all_cut_off,          // nor anybody else
    all_crash,            // every process dies, those of other hosts for as long as it lasts
    leave,                // it says farewell and ends
    hang,                 // it says Hello and does nothing
    forget_chain,         // it does not hold the chain any more
    lack_memory,          // batches of more than `detail` units do not fit
    lie,                  // it answers wrongly: always, seldom or once (`detail`)
    damage,               // its next answer is no answer
    coordinator_held_up,  // takes no step
    abandon,              // the requester gives everything up and begins again
    // Strangers, in the worker's name: with an origin of their own, or without one (`detail`)
    false_hello,
    false_farewell,
    false_answer,
    fake_worker,  // comes under a name of its own, takes batches, answers none or nonsense
    other_build,  // a worker of another protocol or build
    deadly_unit,  // some unit ends every process that computes it, or every worker's (`detail`)
  };
  static constexpr int kKinds = 20;
  Kind kind = Kind::crash;
  Nanos at = 0;
  Nanos lasts = 0;
  std::uint32_t target = 0;  // seat of a worker
  std::uint32_t detail = 0;
};

std::string in_words(const Fault& fault);

struct Scenario {
  std::uint64_t seed = 0;
  std::uint32_t workers = 1;   // seats
  std::uint32_t guests = 0;    // honest workers of other hosts beside them, whose process numbers are the same
  bool at_once = false;        // all come at the same instant
  std::uint32_t lanes = 1;     // of each
  bool own_processes = false;  // the coordinator starts them, and sees them end
  std::uint32_t clients = 1;   // requests at once
  std::uint32_t demes = 0;     // of the clients: each asks for one epoch after another, when its neighbour is as far
  std::uint32_t epoch = 1;     // what an epoch takes, in units
  std::uint32_t requests = 1;  // of each client, one after another
  std::uint32_t units = 1;     // of a request
  std::uint32_t portions = 1;  // in which they come
  Nanos each = kMillisecond;   // computing a unit
  Nanos delay = 50 * kMicrosecond;  // of a message, at least; on average twice that
  std::uint32_t lost = 0;           // messages of a million
  std::uint32_t doubled = 0;        // answers of a million
  std::uint32_t cross_check = 0;    // units of a thousand
  // Limits of the dispatcher, often extreme: what is rare otherwise happens all the time then.
  std::uint32_t ahead = 1;
  std::uint32_t copies = 2;
  std::uint32_t isolate_after = 2;
  std::uint32_t apart_after = 3;
  std::uint32_t lost_before_apart = 8;
  std::vector<Fault> faults;

  std::uint64_t total_requests() const { return std::uint64_t{clients} * requests; }
  std::uint32_t seats() const { return workers + guests; }
};

Scenario scenario_of(std::uint64_t seed);
// So many workers that come at the same instant, and one request of ten units for each; no faults.
Scenario arrival_of(std::uint32_t workers);
// The command that runs exactly this.
std::string command_of(const Scenario& scenario, const std::string& mutation);

}  // namespace coppice::simulation
