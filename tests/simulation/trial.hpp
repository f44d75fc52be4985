// Runs scenarios and makes those that fail smaller. Each runs in a process of its own when it may end it: a broken
// COPPICE_CHECK is a finding like any other.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "tests/simulation/scenario.hpp"
#include "tests/simulation/world.hpp"

namespace coppice::simulation {

struct Finding {
  std::string name;  // of the promise that was broken; "ended" for a process that did
  std::string how;
};

// In this process. Throws nothing. A run whose seed says so is made twice, and must be the same.
std::optional<Finding> run_here(const Scenario& scenario, Report* report = nullptr);
// In a child process, which may end.
std::optional<Finding> run_apart(const Scenario& scenario);
// What the dispatcher allocates for each of so many workers that are ready and hold a batch in each lane and one ahead.
std::size_t bytes_of_a_worker(std::uint32_t workers);
// The smallest scenario found, by at most `most` runs, that breaks the same promise: fewer faults, then fewer workers,
// requesters, requests, units.
Scenario shrunk(Scenario scenario, const Finding& finding, int most = 400);

}  // namespace coppice::simulation
