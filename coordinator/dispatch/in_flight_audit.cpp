// What must always hold of the in-flight table, spelled out.
#include <fmt/format.h>

#include "coordinator/dispatch/in_flight.hpp"

namespace coppice {

std::string InFlight::inconsistency() const {
  struct Held {
    std::size_t out = 0;
    std::uint32_t units = 0;
    bool alone = false;
  };
  std::map<WorkerId, Held> held;
  std::map<RequestId, std::vector<bool>> somewhere;
  for (const auto& [id, request] : requests_) {
    somewhere.emplace(id, request.settled);
  }
  const auto mark = [&somewhere](RequestId id, std::uint32_t first, std::uint32_t count) {
    if (const auto found = somewhere.find(id); found != somewhere.end()) {
      std::fill_n(found->second.begin() + first, count, true);
    }
    return somewhere.count(id) != 0;
  };
  std::uint32_t waiting = 0;
  std::uint32_t isolated = 0;
  for (const Range& range : queue_) {
    if (!mark(range.request, range.first, range.count)) {
      return "a unit of a closed request waits";
    }
    waiting += range.count;
    isolated += range.alone ? range.count : 0;
  }
  for (const Unit& unit : apart_) {
    if (!mark(unit.request, unit.index, 1)) {
      return "a unit of a closed request waits to be computed apart";
    }
  }
  for (const auto& [id, out] : out_) {
    if (!out.lost) {
      mark(out.batch.request, out.batch.first, out.batch.count);
      if (out.worker != kHome) {
        Held& at = held[out.worker];
        ++at.out;
        at.units += out.batch.count;
        at.alone = at.alone || out.alone;
      }
    }
  }
  if (waiting != waiting_ || isolated != isolated_waiting_) {
    return fmt::format("{} units wait ({} isolated), counted as {} ({})", waiting, isolated, waiting_,
                       isolated_waiting_);
  }
  for (const auto& [id, worker] : workers_) {
    const Held at = held[id];
    if (at.out != worker.out || at.units != worker.units || at.alone != worker.alone) {
      return fmt::format("a worker holds {} batches of {} units, charged with {} of {}", at.out, at.units, worker.out,
                         worker.units);
    }
  }
  if (held.size() != workers_.size()) {
    return "somebody who is not there holds a batch";
  }
  std::uint32_t unsettled = 0;
  for (const auto& [id, request] : requests_) {
    std::uint32_t open = 0;
    for (std::uint32_t unit = 0; unit < request.settled.size(); ++unit) {
      open += request.settled[unit] ? 0 : 1;
      if (!somewhere.at(id)[unit]) {
        return fmt::format("unit {} of request {} is nowhere", unit, static_cast<std::uint64_t>(id));
      }
    }
    if (open != request.unsettled) {
      return fmt::format("{} units of a request are unsettled, counted as {}", open, request.unsettled);
    }
    unsettled += open;
  }
  return unsettled == unsettled_ ? "" : fmt::format("{} units are unsettled, counted as {}", unsettled, unsettled_);
}

}  // namespace coppice
