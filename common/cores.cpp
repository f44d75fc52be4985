#include "common/cores.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sched.h>

namespace coppice {

std::vector<int> usable_cores() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cores;
  if (sched_getaffinity(0, sizeof set, &set) != 0) {
    return cores;  // more cores than the set holds: none is known by name
  }
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (CPU_ISSET(core, &set)) {
      cores.push_back(core);
    }
  }
  return cores;
}

Result<void> stay_on_cores(std::span<const int> cores) {
  const std::vector<int> usable = usable_cores();
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int core : cores) {
    if (std::ranges::find(usable, core) == usable.end()) {
      return bad_input(
          fmt::format("found core {}, expected some of {}, which this process may use", core, fmt::join(usable, ", ")));
    }
    CPU_SET(core, &set);
  }
  if (sched_setaffinity(0, sizeof set, &set) != 0) {
    return bad_input(fmt::format("cores {}: {}", fmt::join(cores, ", "), std::strerror(errno)));
  }
  return {};
}

}  // namespace coppice
