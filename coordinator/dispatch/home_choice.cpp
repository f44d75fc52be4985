#include "coordinator/dispatch/home_choice.hpp"

#include <algorithm>
#include <utility>

#include "common/check.hpp"

namespace coppice {

void HomeChoice::Mean::add(double measured) {
  weight = std::min(weight + 1.0, kMemory);
  value += (measured - value) / weight;
}

HomeChoice::Class& HomeChoice::at(const WorkClass& work) {
  const auto found =
      std::find_if(classes_.begin(), classes_.end(), [&](const Class& known) { return known.work == work; });
  if (found != classes_.end()) {
    std::rotate(classes_.begin(), found, found + 1);
    return classes_.front();
  }
  classes_.resize(std::min(classes_.size(), kClasses - 1));
  classes_.insert(classes_.begin(), Class{.work = work, .here = {}, .there = {}});
  return classes_.front();
}

double HomeChoice::there(const Class& known, double units, std::size_t lanes) const {
  const auto gaining = static_cast<double>(std::clamp<std::size_t>(lanes, 1, cores_));
  const double expected = static_cast<double>(Nanoseconds(kFirstGuess).count()) + here(known, units) / gaining;
  return known.there.known() ? known.there.value * units : expected;
}

HomeChoice::Way HomeChoice::way(const WorkClass& work, std::uint32_t units, std::size_t lanes) {
  COPPICE_CHECK(units >= 1);
  const Class& known = at(work);
  if (!known.here.known()) {
    return Way::probe;
  }
  const double home = here(known, units);
  if (lanes == 0) {
    return home > static_cast<double>(Nanoseconds(kLong).count()) ? Way::workers : Way::home;
  }
  const double workers = there(known, units, lanes);
  const Way better = home <= workers ? Way::home : Way::workers;
  const double loss = std::max(home, workers) - std::min(home, workers);
  if (loss <= kTrial * spent_) {
    spent_ = 0.0;
    return better == Way::home ? Way::workers : Way::home;
  }
  return better;
}

bool HomeChoice::would_gain(const WorkClass& work, std::uint32_t units, std::size_t lanes) {
  const Class& known = at(work);
  return lanes > 0 && known.here.known() && there(known, units, lanes) < here(known, units);
}

void HomeChoice::probed(const WorkClass& work, std::uint32_t units, Nanoseconds elapsed) {
  Class& known = at(work);
  known.here.add(static_cast<double>(elapsed.count()) / units);
  known.here.weight = 0.5;  // a request as a whole counts for more
}

void HomeChoice::took_home(const WorkClass& work, std::uint32_t units, Nanoseconds elapsed) {
  at(work).here.add(static_cast<double>(elapsed.count()) / units);
  spent_ += static_cast<double>(elapsed.count());
}

void HomeChoice::took_workers(const WorkClass& work, std::uint32_t units, Nanoseconds elapsed) {
  Class& known = at(work);
  if (std::exchange(known.sent, true)) {
    known.there.add(static_cast<double>(elapsed.count()) / units);
  }
  spent_ += static_cast<double>(elapsed.count());
}

}  // namespace coppice
