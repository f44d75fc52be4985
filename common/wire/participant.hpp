// One process' place in a DDS domain: domain, participant, publisher and subscriber. Readers and writers are made from
// it (topics.hpp) and must go before it. Signals must be blocked before it is made: DDS threads inherit the mask.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "common/error.hpp"
#include "common/wire/entity.hpp"

namespace coppice::wire {

class Participant {
 public:
  // `configuration` is XML (configuration.hpp); the environment's CYCLONEDDS_URI replaces it when set.
  // Errors carry what DDS said, e.g. that the coordinator's port is taken.
  static Result<Participant> join(std::uint32_t domain, const std::string& configuration);

  dds_entity_t get() const { return participant_.get(); }
  // Other participants that were met and are still there, whoever they are.
  std::size_t others() const;

 private:
  Participant(Entity domain, Entity participant) : domain_(std::move(domain)), participant_(std::move(participant)) {}

  Entity domain_;  // first: outlives the participant
  Entity participant_;
};

// What libddsc prints goes through here instead of straight to stderr: at most kMaxDdsLinesPerSecond lines reach
// `sink`, so that a flood of malformed packets cannot fill a disk. Call once, before the first join(); thread-safe.
inline constexpr int kMaxDdsLinesPerSecond = 5;
void route_dds_log(void (*sink)(const char* line));

}  // namespace coppice::wire
