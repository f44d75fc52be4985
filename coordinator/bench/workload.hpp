// What `coppice bench` evaluates: a population of random trees, the same for every run and each with a meaning of
// its own, and a job of a given size.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/fitness/job.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

struct Workload {
  std::string name;
  std::vector<Tree> trees;
  Job job;                        // of generation 0
  std::uint32_t generations = 1;  // that are timed together, so that a short one is not lost in the clock

  Job job_of(std::uint32_t generation) const;
};

inline constexpr std::uint32_t kThesisPopulation = 100;  // thesis Table III

// "empty": one step: what remains is dispatch. "light": the thesis' size. "medium", "heavy": more and longer
// roll-outs.
std::vector<Workload> standard_workloads(const Chain& chain);

// `population` trees at the thesis' size.
Workload light_workload(const Chain& chain, std::uint32_t population);

}  // namespace coppice
