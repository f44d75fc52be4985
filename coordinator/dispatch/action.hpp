// What the dispatcher wants done, in the order in which it is to be done. Values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/error.hpp"
#include "coordinator/dispatch/in_flight.hpp"
#include "coordinator/dispatch/work.hpp"

namespace coppice {

// Make what a worker is written to with; take it down.
struct OpenLink {
  WorkerId worker{};
};
struct CloseLink {
  WorkerId worker{};
};

struct SendTask {
  WorkerId worker{};
  Batch batch;
  bool copy = false;
};

struct SendBlocks {
  WorkerId worker{};
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

// Tell everybody of the run: somebody does not know of it.
struct Announce {};

// Compute these units here, and tell (Computed). `apart`: in a process of its own, because processes died of it.
struct Compute {
  ComputeId id{};
  RequestId request{};
  std::vector<std::uint32_t> units;
  bool apart = false;
};

// A worker process, in the place of one that ended.
struct StartProcess {
  std::size_t place = 0;
};

struct Say {
  enum class Level : std::uint8_t { debug, warn, error };
  Level level = Level::warn;
  std::string text;
};

using Action = std::variant<OpenLink, CloseLink, SendTask, SendBlocks, Announce, Compute, StartProcess, Say>;

// Nothing more comes of the open requests.
struct Failure {
  Error error;
  // It failed because processes died of this unit, one of the coordinator's own among them.
  std::optional<Unit> deadly;
};

struct Actions {
  std::vector<Action> actions;
  std::optional<Failure> failure;
  InFlight::Time wake_at;  // the next step is due then, or sooner if something happens
};

}  // namespace coppice
