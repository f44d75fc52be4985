// Who holds a UDP port of this machine, as far as the system lets us see: for the message that a domain is taken.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <sys/types.h>

namespace coppice {

struct PortHolder {
  std::string user;          // by name, else by number
  std::optional<pid_t> pid;  // unknown where the process is another user's
  std::string command;       // its command line, cut to kMostCommand characters; not fit for a terminal as it is
  bool ipv6 = false;         // the port is one of IPv6
  static constexpr std::size_t kMostCommand = 200;
};

// Empty: nobody, in this network namespace.
std::optional<PortHolder> udp_port_holder(std::uint32_t port);

// "pid 12, user anna: coppice evolve ..."
std::string in_words(const PortHolder& holder);

}  // namespace coppice
