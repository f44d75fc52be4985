// Which cores of the machine this process may use, and how a thread stays on one of them.
//
// Evaluating threads that fill a machine each keep to a core of their own: when the coordinator writes to two workers
// at once, the system tends to wake both on the core that wrote, and moves one away only milliseconds later, which is
// as long as a small generation takes (coordinator/bench/README.md).
#pragma once

#include <span>
#include <vector>

#include "common/error.hpp"

namespace coppice {

// By number, ascending. What taskset, a cgroup's cpuset or Slurm leave to this process.
std::vector<int> usable_cores();

// The calling thread, and the threads that it starts, run on these cores only, from now on. Errors: bad_input, one of
// them is not among usable_cores(), or there is none.
Result<void> stay_on_cores(std::span<const int> cores);

}  // namespace coppice
