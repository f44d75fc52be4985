// The workers that a coordinator knows: met by their Hello, let go when they leave, die, hang or answer nonsense; and
// whose name is whose. A name belongs for good to the origin that was first heard under it: samples of any other origin
// say nothing about its worker, neither that it lives nor that it is gone. Pure; time is passed in.
//
// Silence is measured in listened time, which passes only while the coordinator listens: when it was itself held up,
// the Hellos of that time are still on their way to it.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <sys/types.h>
#include <vector>

#include "coordinator/dispatch/event.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/measured_pace.hpp"
#include "coordinator/dispatch/work.hpp"

namespace coppice {

struct KnownWorker {
  Origin origin{};
  std::string name;
  pid_t pid = 0;
  bool here = false;
  std::size_t lanes = 1;
  bool serves = false;
  bool holds_chain = false;
  bool linked = false;  // what is sent reaches it
  std::uint64_t evaluated = 0;
  std::chrono::nanoseconds heard{0};        // listened time of its last sign of life
  std::chrono::nanoseconds progressed{0};   // since when its count stands still, or since it was last given work
  std::chrono::nanoseconds rests_until{0};  // listened time: gets nothing before
  MeasuredPace pace;

  bool ready() const { return serves && holds_chain && linked; }
};

class Roster {
 public:
  static constexpr std::size_t kMaxWorkers = 1024;
  static constexpr std::size_t kMaxRemembered = 4096;  // names of workers that are gone, banned ones, logged sources
  static constexpr std::size_t kMaxLanes = 32;         // half of what a worker's queue of tasks holds
  // A worker says Hello four times a second; unheard for so long it is out of reach.
  static constexpr std::chrono::milliseconds kSilence{2000};
  static constexpr std::chrono::milliseconds kMostListened{250};  // that pass between two looks

  // Time passes. REQUIRES: `now` never goes back.
  void listen(InFlight::Time now);
  std::chrono::nanoseconds listened() const { return listened_; }

  // Null: not known, or no more.
  KnownWorker* find(WorkerId id);
  const KnownWorker* find(WorkerId id) const;
  const std::map<WorkerId, KnownWorker>& all() const { return workers_; }
  std::map<WorkerId, KnownWorker>& all() { return workers_; }
  std::size_t ready() const;
  bool full() const { return workers_.size() >= kMaxWorkers; }

  enum class Speaker : std::uint8_t {
    own,      // the one to whom the name belongs
    first,    // nobody was heard under this name
    other,    // somebody else
    unknown,  // his writer is gone, so that nobody can tell
  };
  Speaker speaker(WorkerId name, const std::optional<Origin>& origin) const;

  // REQUIRES: the speaker is own or first; not known; not full.
  KnownWorker& meet(const HelloHeard& hello);
  // Takes what a Hello of its own says.
  void hear(KnownWorker& worker, const HelloHeard& hello);
  void let_go(WorkerId id);
  // Workers that were not heard for kSilence.
  std::vector<WorkerId> silent() const;

  void ban(WorkerId id);
  bool is_banned(WorkerId id) const { return banned_.count(id) != 0; }
  bool is_liar(WorkerId id) const { return liars_.count(id) != 0; }
  bool is_refused(WorkerId id) const { return refused_.count(id) != 0; }
  // True the first time for each.
  bool first_refusal(WorkerId id) { return remember(refused_, id); }
  bool first_lie(WorkerId id) { return remember(liars_, id); }
  bool first_nonsense(WorkerId id) { return remember(nonsense_from_, id); }

 private:
  static bool remember(std::set<WorkerId>& set, WorkerId id) {
    return set.size() < kMaxRemembered && set.insert(id).second;
  }

  std::map<WorkerId, KnownWorker> workers_;
  std::map<WorkerId, Origin> names_;  // of all known workers, and of those that left last
  std::deque<WorkerId> departed_;     // in this order
  std::set<WorkerId> banned_;         // answered nonsense: not heard any more
  std::set<WorkerId> liars_;          // of them, those that answered wrongly
  std::set<WorkerId> refused_;
  std::set<WorkerId> nonsense_from_;
  std::optional<InFlight::Time> last_;
  std::chrono::nanoseconds listened_{0};
};

}  // namespace coppice
