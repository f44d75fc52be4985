// The Cyclone DDS configuration of both programs: a star. The coordinator listens on the fixed port of its domain,
// nobody multicasts, and a worker's only peer is the coordinator, so workers never discover each other: N workers cost
// N meetings, not N^2, one open UDP port is enough, and one picture serves one machine, many hosts and containers.
// A user's CYCLONEDDS_URI replaces what is built here.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <sys/socket.h>
#include <vector>

#include "common/error.hpp"

namespace coppice::wire {

inline constexpr std::uint32_t kMaxDomain = 230;  // the largest whose ports fit 16 bits

// The one UDP port on which the coordinator of a domain listens: 7410 + 250 x domain (DDSI-RTPS 9.6.1.1, participant
// 0, discovery). We differ: RTPS puts data on the next port; ours comes to the same, so that one is to be opened.
inline constexpr std::uint32_t coordinator_port(std::uint32_t domain) { return 7410 + 250 * domain; }

// What a network asks for beyond where the coordinator is. All who meet must agree on `security`, and should on
// `lossy`.
struct Network {
  std::filesystem::path security;  // folder of an identity (credentials.hpp); empty: nothing is signed or encrypted
  // Packets that pass through any network in one piece (kSmallPacket), and repair within milliseconds. Costs a
  // third of the throughput where nothing is ever lost.
  bool lossy = false;
  // Coordinator: the address under which workers reach it where that is not its own, in numbers. Its port must be
  // forwarded under its own number.
  std::string advertise = {};
  std::optional<std::uint16_t> port;  // worker: UDP port to listen on; else one that the system chooses
};

inline constexpr int kSmallPacket = 1152;  // bytes of UDP payload: leaves 100 bytes for encryption below IPv6's 1280

// Where a coordinator listens, as the socket interface has it.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = 0;
};
// Errors (bad_input): the host does not resolve.
Result<SocketAddress> coordinator_address(const std::string& host, std::uint32_t domain);

// XML for the coordinator. `interface` is a network interface by name or address ("lo", "eth0", "192.0.2.7",
// "2001:db8::7"). IPv6 is used on an interface that has nothing else, or where an address says so: one of the two.
std::string coordinator_configuration(const std::string& interface, const Network& network = {});

// XML for a worker that finds its coordinator at an address, or at a name, of whose addresses one of IPv4 is preferred;
// a link-local address names its interface ("fe80::7%eth0"). The worker uses the interface from which the machine's
// routes reach that address. Errors: the host does not resolve, there is no route.
Result<std::string> worker_configuration(const std::string& coordinator_host, std::uint32_t domain,
                                         const Network& network = {});

// Addresses of this machine's interfaces, or of one, given by name or address: IPv4, then IPv6, link-local ones last.
std::vector<std::string> addresses_of(const std::string& interface = {});

// Errors (bad_input): no address in numbers, or of the other family than the interface is used with.
Result<void> check_advertised(const std::string& address, const std::string& interface);

// Errors: a name that is neither an interface of this machine nor an address of one, naming those that exist.
Result<void> check_interface(const std::string& interface);

}  // namespace coppice::wire
