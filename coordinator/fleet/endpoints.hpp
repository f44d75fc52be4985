// A coordinator's place in its DDS domain: the participant, and every endpoint that it shares among workers (those
// of one worker are in link.hpp). Belongs to one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/wire/configuration.hpp"
#include "common/wire/origin.hpp"
#include "common/wire/participant.hpp"
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"

namespace coppice {

struct Endpoints {
  std::uint32_t domain = 0;
  wire::Participant participant;
  wire::Waiter waiter;  // watches the readers
  wire::Reader<wire::Hello> hellos;
  wire::Reader<wire::Answer> answers;
  wire::Reader<wire::ChainRequest> requests;
  wire::Writer<wire::Control> control;
  wire::Writer<wire::Fleet> fleet;
  wire::Origins origins{};  // of what the readers take

  // In `domain`, or in a free one of those for local runs. `interface` by name or address. Errors name the flag: no
  // such interface; the domain is taken (or all are).
  static Result<Endpoints> open(const std::optional<std::uint32_t>& domain, const std::string& interface,
                                const wire::Network& network = {});
  // Those of these errors that can be found ahead of time: the interface, and the identity under DDS Security.
  static Result<void> check(const std::string& interface, const wire::Network& network);
};

}  // namespace coppice
