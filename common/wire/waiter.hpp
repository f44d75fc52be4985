// Sleeps until a sample arrives, a writer is matched, or somebody calls wake(). One thread waits; wake() is safe
// from any thread (never from a signal handler).
#pragma once

#include <chrono>
#include <vector>

#include "common/error.hpp"
#include "common/wire/entity.hpp"
#include "common/wire/participant.hpp"

namespace coppice::wire {

class Waiter {
 public:
  static Result<Waiter> make(const Participant& participant);

  // Wakes on any sample in the reader. The reader must outlive this Waiter, or be forgotten by deleting it.
  Result<void> watch_reader(dds_entity_t reader);
  // Wakes when a reader comes or goes; Writer::matched() clears the cause.
  Result<void> watch_matching(dds_entity_t writer);

  // Returns when something happened or the time is over; wake() calls are consumed. True: a watched writer was matched
  // or lost its reader.
  bool wait(std::chrono::nanoseconds timeout);
  void wake() const;

 private:
  Waiter(Entity waitset, Entity guard) : waitset_(std::move(waitset)), guard_(std::move(guard)) {}

  Entity waitset_;
  Entity guard_;
  std::vector<Entity> conditions_;
};

}  // namespace coppice::wire
