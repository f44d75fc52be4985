// What happens to a coordinator, as the dispatcher is told of it. Values.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <sys/types.h>
#include <variant>
#include <vector>

#include "common/error.hpp"
#include "coordinator/dispatch/work.hpp"

namespace coppice {

// Who wrote a sample, as the transport vouches for it (under DDS: the participant's GUID). Whoever speaks in a worker's
// name is that worker only if his origin is.
using Origin = std::array<std::uint8_t, 16>;

// A worker said who it is and how far it got.
struct HelloHeard {
  WorkerId worker{};
  std::optional<Origin> origin;  // empty: its writer is gone, nobody can tell
  std::string name;              // "host, pid 123", fit for a terminal
  std::string version;           // likewise
  std::uint32_t protocol = 0;
  std::uint64_t golden = 0;  // checksum of what its build makes of the golden job
  pid_t pid = 0;
  bool here = false;  // says that it is on this machine
  std::size_t lanes = 1;
  std::uint64_t evaluated = 0;  // since its start; stands still when it hangs
  bool leaving = false;
  bool serves = false;       // knows of this run
  bool holds_chain = false;  // of this run
};

struct AnswerHeard {
  enum class Kind : std::uint8_t {
    computed,
    given_back,     // it leaves; nothing was computed
    chain_unknown,  // it does not hold the chain (any more)
    no_memory,      // its memory did not suffice for the batch
    refused,        // `text` says why
    damaged,        // what came is no answer to that batch; `text` says why
  };
  WorkerId worker{};
  std::optional<Origin> origin;
  BatchId batch{};
  Kind kind = Kind::computed;
  std::chrono::nanoseconds elapsed{0};  // computing, as the worker says
  std::uint32_t repeated = 0;           // units that it found to be the same as others of the batch
  std::uint64_t bytes = 0;
  std::vector<UnitOutcome> outcomes;  // one for each unit of the batch, if it was found (Dispatcher::find)
  std::string text;
};

// A worker lacks these blocks of the chain.
struct BlocksAsked {
  WorkerId worker{};
  std::optional<Origin> origin;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

// A sample that is of another run, or makes no sense.
struct NonsenseHeard {
  WorkerId worker{};
  std::string what;
};

// What is sent to the worker from now on reaches it; or does not any more.
struct LinkChanged {
  WorkerId worker{};
  bool settled = false;
};

struct SendFailed {
  WorkerId worker{};
  BatchId batch{};
  std::string why;
};

// A process of this coordinator's own.
struct ProcessStarted {
  std::size_t place = 0;
  pid_t pid = 0;
};
struct ProcessEnded {
  std::size_t place = 0;
  pid_t pid = 0;          // 0: it could not be started
  bool in_order = false;  // it left; else it died
  std::string how;
};

// What the coordinator computed itself.
struct Computed {
  ComputeId id{};
  std::chrono::nanoseconds elapsed{0};
  std::vector<UnitOutcome> outcomes;  // one for each unit
  std::string died;                   // not empty: the process apart ended before it had an outcome, in this way
};

using DispatchEvent = std::variant<HelloHeard, AnswerHeard, BlocksAsked, NonsenseHeard, LinkChanged, SendFailed,
                                   ProcessStarted, ProcessEnded, Computed>;

}  // namespace coppice
