// One who plays the coordinator towards workers, and listens to what is meant for the coordinator, whatever rights its
// identity gives it (stranger.cpp).
#pragma once

#include <cstdint>
#include <string>

#include "common/wire/configuration.hpp"

namespace coppice::e2e {

struct Usurper {
  std::uint32_t domain = 0;
  wire::Network network;  // with the identity
  // What enforces the rules in this process: "own", the plugin of DDS, or a function of lawless.cpp to use instead.
  std::string rules = "own";
  std::string worker_port;  // of a worker on this machine, knocked at beside the coordinator
};

// Waits a while for a coordinator's announcement (with "init_lawless", until it comes), then sends orders and listens
// for a few seconds, and prints what reached a reader and what was heard. Returns an exit code.
int usurp(const Usurper& usurper);

}  // namespace coppice::e2e
