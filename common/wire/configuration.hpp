// The Cyclone DDS configuration of both programs: a star. The coordinator listens on the fixed port of its domain,
// nobody multicasts, and a worker's only peer is the coordinator, so workers never discover each other: N workers cost
// N meetings, not N^2, one open UDP port is enough, and one picture serves one machine, many hosts and containers.
// A user's CYCLONEDDS_URI replaces what is built here.
#pragma once

#include <cstdint>
#include <string>

#include "common/error.hpp"

namespace coppice::wire {

inline constexpr std::uint32_t kMaxDomain = 230;  // the largest whose ports fit 16 bits

// UDP port on which the coordinator of a domain listens: 7410 + 250 x domain (DDSI-RTPS 9.6.1.1, participant 0).
inline constexpr std::uint32_t coordinator_port(std::uint32_t domain) { return 7410 + 250 * domain; }

// XML for the coordinator. `interface` is a network interface by name or address ("lo", "eth0", "192.0.2.7").
std::string coordinator_configuration(const std::string& interface);

// XML for a worker that finds its coordinator at an IPv4 address. The worker uses the interface from which the
// machine's routes reach that address. Errors: the host does not resolve, there is no route.
Result<std::string> worker_configuration(const std::string& coordinator_host, std::uint32_t domain);

// Errors: a name that is neither an interface of this machine nor an address of one, naming those that exist.
Result<void> check_interface(const std::string& interface);

}  // namespace coppice::wire
