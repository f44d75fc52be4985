// A problem's own simulator: a child process that speaks JSON lines (simulator.md beside this file). Several episodes
// go on at once, so that one line serves many steps. Owns the child. One thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/tree/vocabulary.hpp"
#include "coordinator/learning/child_process.hpp"

namespace coppice {

inline constexpr std::uint32_t kMaxSimulatedAtOnce = 4096;

class ExternalSimulator {
 public:
  // Starts the command and hears its first line. Errors name the command: it cannot be started, ends, is silent for too
  // long, does not speak this protocol; its features or actions are not those of the vocabulary, by name and order.
  // Once `stop` is raised every call ends at once with `interrupted`. REQUIRES: `stop`, if not null, outlives this.
  static Result<ExternalSimulator> start(const std::string& command, const Vocabulary& vocabulary,
                                         const StopFlag* stop = nullptr);

  struct Step {
    std::vector<double> observation;  // [features] readings, each in its own unit
    double reward = 0.0;
    bool terminated = false;  // the task has ended
    bool truncated = false;   // the clock has
    bool collision = false;
  };

  // How many episodes may be under way at once.
  std::uint32_t at_once() const { return at_once_; }
  // Whether its steps say what is a collision.
  bool tells_collisions() const { return tells_collisions_; }

  // Begins episodes in these places, whatever was there. Parallel spans. [episodes x features] Errors as start(), and
  // whatever the child says went wrong. REQUIRES: places below at_once(), each once.
  Result<std::vector<std::vector<double>>> reset(std::span<const std::uint32_t> places,
                                                 std::span<const std::uint64_t> seeds);
  // REQUIRES: as reset(); actions of the vocabulary; episodes that have not ended.
  Result<std::vector<Step>> step(std::span<const std::uint32_t> places, std::span<const ActionId> actions);

 private:
  ExternalSimulator(ChildProcess child, std::string command, std::size_t features)
      : child_(std::move(child)), command_(std::move(command)), features_(features) {}

  Result<std::string> ask(const std::string& request);
  // The line that answers request number id_, and what it says: an object of that number that reports no error.
  Result<std::string> answer_to(const nlohmann::json& request, nlohmann::json& answer);
  tl::unexpected<Error> wrong(const std::string& what, const std::string& line);

  ChildProcess child_;
  std::string command_;
  std::size_t features_;
  std::uint32_t at_once_ = 1;
  bool tells_collisions_ = false;
  std::chrono::milliseconds timeout_{60'000};
  std::uint64_t id_ = 0;  // of the last request
};

}  // namespace coppice
