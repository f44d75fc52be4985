#include "common/wire/short_turns.hpp"

#include <cstdint>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace coppice::wire {
namespace {

constexpr std::uint64_t kShortTurnNs = 100'000;  // the shortest that the system gives
constexpr std::uint64_t kUsualTurn = 0;          // as the system has it

// struct sched_attr of the kernel's interface, first version; its header cannot be included beside <sched.h>.
struct SchedulingAttributes {
  std::uint32_t size;
  std::uint32_t policy;
  std::uint64_t flags;
  std::int32_t nice;
  std::uint32_t priority;
  std::uint64_t runtime;  // nanoseconds; of SCHED_OTHER: the length of a turn
  std::uint64_t deadline;
  std::uint64_t period;
};
static_assert(sizeof(SchedulingAttributes) == 48);

void ask_for_turns(std::uint64_t nanoseconds) {
  SchedulingAttributes attributes{};
  if (syscall(SYS_sched_getattr, 0, &attributes, sizeof attributes, 0) != 0 ||
      (attributes.policy != SCHED_OTHER && attributes.policy != SCHED_BATCH)) {
    return;
  }
  attributes.runtime = nanoseconds;
  syscall(SYS_sched_setattr, 0, &attributes, 0);  // what is refused costs time only
}

}  // namespace

ShortTurns::ShortTurns() { ask_for_turns(kShortTurnNs); }
ShortTurns::~ShortTurns() { ask_for_turns(kUsualTurn); }

}  // namespace coppice::wire
