// Hosts made of network namespaces: each has an interface eth0 of its own (10.99.0.1, 10.99.0.2, ...), joined by a
// bridge in one more namespace, the switch. Links go down, lose, delay and shrink as a test asks. Needs root; who has
// not gets to know from why_not(). Everything is gone with the object, and what a killed test left behind, with the
// next one.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/e2e/process.hpp"

namespace coppice::e2e {

class Hosts {
 public:
  // Why there can be none here; empty: there can.
  static std::optional<std::string> why_not();

  // Hosts 1 to `count`. REQUIRES: !why_not(). Throws when a command fails.
  explicit Hosts(std::size_t count);
  Hosts(const Hosts&) = delete;
  Hosts& operator=(const Hosts&) = delete;
  ~Hosts();

  static std::string address(std::size_t host) { return "10.99.0." + std::to_string(host); }
  // The command, to be run on a host.
  Command on(std::size_t host, Command command) const;

  void set_link(std::size_t host, bool up) const;
  // Bytes of a packet on this host's link; with `fragments` false the network drops what was cut into pieces.
  void set_mtu(std::size_t host, int bytes) const;
  void drop_fragments() const;
  // Of all packets that cross the switch; 0: none.
  void lose(int percent) const;
  // Each way, on this host's link.
  void delay(std::size_t host, int milliseconds);
  // No longer.
  void hasten(std::size_t host);
  // nftables rules in a chain that sees what a host takes in; all else is dropped but on its loopback interface.
  void admit_only(std::size_t host, const std::string& rules) const;
  // `ip -n HOST arguments`, for addresses and routes of a test's own.
  void ip_on(std::size_t host, const std::string& arguments) const;
  // What this IPv6 host is called here: a global (unique local) address and a link-local one, both at once usable.
  static std::string address6(std::size_t host) { return "fd00:99::" + std::to_string(host); }
  static std::string link_local(std::size_t host) { return "fe80::99:" + std::to_string(host); }
  void use_ipv6_only() const;
  // From now on `hidden` is in a network of its own behind `router`, which forwards a UDP port of its own to it.
  void hide_behind(std::size_t router, std::size_t hidden, int port) const;
  // A second interface, eth1, that joins two hosts alone: 10.97.0.HOST.
  void join_directly(std::size_t one, std::size_t other) const;

 private:
  std::string name(std::size_t host) const { return prefix_ + "h" + std::to_string(host); }
  std::string network_switch() const { return prefix_ + "sw"; }

  std::string prefix_;
  std::size_t count_;
  std::map<std::size_t, std::unique_ptr<Process>> delays_;  // by host
};

}  // namespace coppice::e2e
