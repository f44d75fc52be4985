// Whether a request is computed by the coordinator itself, because sending it would take longer. It learns from what
// both ways took: for each class of work, the time of a unit here and by the workers; and what a request costs that is
// sent, whatever it holds. A way that lost is tried again now and then, as long as trying costs less than kTrial of the
// time spent. It decides time only, never a result. Pure: times are passed in.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "coordinator/dispatch/work.hpp"

namespace coppice {

class HomeChoice {
 public:
  using Nanoseconds = std::chrono::nanoseconds;

  static constexpr double kTrial = 0.01;       // of all time, for the way that lost
  static constexpr double kMemory = 8.0;       // requests of which a mean remembers
  static constexpr std::size_t kClasses = 16;  // the classes of work that were met last
  // What nobody has measured yet: a request that is sent, beyond its units.
  static constexpr std::chrono::microseconds kFirstGuess{300};
  // A unit's time here is found out by computing so many of a request first.
  static constexpr std::uint32_t kProbe = 8;
  // A request that is longer is left to the workers from the start, also when none is there yet.
  static constexpr std::chrono::milliseconds kLong{20};

  // `cores`: of this machine; more lanes than cores gain nothing.
  explicit HomeChoice(std::size_t cores) : cores_(cores) {}

  enum class Way : std::uint8_t {
    home,
    workers,
    probe,  // compute kProbe units, tell (probed), ask again
  };
  // For a request of so many units; `lanes` of workers are ready. REQUIRES: units >= 1.
  Way way(const WorkClass& work, std::uint32_t units, std::size_t lanes);

  // Whether workers with so many lanes, if they were there, are expected to do it sooner. False: nobody knows.
  bool would_gain(const WorkClass& work, std::uint32_t units, std::size_t lanes);

  // What happened.
  void probed(const WorkClass& work, std::uint32_t units, Nanoseconds elapsed);
  void took_home(const WorkClass& work, std::uint32_t units, Nanoseconds elapsed);
  // The first of a class does not count: the workers got ready for it, and nobody knew their pace.
  void took_workers(const WorkClass& work, std::uint32_t units, Nanoseconds elapsed);

 private:
  struct Mean {
    double value = 0.0;   // nanoseconds
    double weight = 0.0;  // measurements
    void add(double measured);
    bool known() const { return weight > 0.0; }
  };
  struct Class {
    WorkClass work;
    Mean here;  // a unit
    Mean there;
    bool sent = false;  // before
  };
  Class& at(const WorkClass& work);
  double here(const Class& known, double units) const { return known.here.value * units; }
  double there(const Class& known, double units, std::size_t lanes) const;

  std::size_t cores_;
  std::vector<Class> classes_;  // the one met last is first
  double spent_ = 0.0;          // nanoseconds, since the loser was tried last, on trials' account
};

}  // namespace coppice
