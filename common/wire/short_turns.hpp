// A thread that wakes to pass a message on, and sleeps again, must not wait until the thread that computes on its
// processor has had its turn: since Linux 6.6 that takes up to some milliseconds, in which whoever waits for the
// message has nothing to do. From Linux 6.12 on a thread can ask for turns of another length, and a woken one with a
// shorter turn runs at once (sched_setattr(2), sched_runtime of SCHED_OTHER). Its share of the processor stays what it
// is. Where the system knows nothing of this, nothing happens.
#pragma once

namespace coppice::wire {

// For the calling thread, and for threads that it starts, while this lives; then its turns are of the usual length
// again.
class ShortTurns {
 public:
  ShortTurns();
  ~ShortTurns();
  ShortTurns(const ShortTurns&) = delete;
  ShortTurns& operator=(const ShortTurns&) = delete;
};

}  // namespace coppice::wire
