// The other half of the coordinator's seam: epochs of demes in, demes out, in whatever order they end. An epoch is a
// pure function of its task, so whoever runs it, and however often, the result is the same bits.
#pragma once

#include <cstdint>
#include <memory>

#include "common/error.hpp"
#include "common/evolution/epoch.hpp"

namespace coppice {

// Belongs to one thread.
class DemeEvolver {
 public:
  DemeEvolver() = default;
  DemeEvolver(const DemeEvolver&) = delete;
  DemeEvolver& operator=(const DemeEvolver&) = delete;
  virtual ~DemeEvolver() = default;

  // Begins an epoch; `ticket` names it, and is free again once next() has given it back. Does not wait.
  // REQUIRES: check_search(*config), EpochCheck::task(task) with it.
  virtual void submit(std::uint64_t ticket, std::shared_ptr<const EvolveConfig> config, EpochTask task) = 0;

  struct Finished {
    std::uint64_t ticket = 0;
    EpochResult result;
  };
  // Waits for any epoch that was submitted. REQUIRES: there is one. Errors: interrupted (the stop flag was raised), and
  // those of whoever runs it. After an error whatever was submitted is dropped.
  virtual Result<Finished> next() = 0;
};

}  // namespace coppice
