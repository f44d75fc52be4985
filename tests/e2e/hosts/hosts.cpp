#include "tests/e2e/hosts/hosts.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <signal.h>
#include <stdexcept>
#include <unistd.h>

namespace coppice::e2e {
namespace {

constexpr const char* kIp = "/sbin/ip";
constexpr const char* kNft = "/usr/sbin/nft";
constexpr const char* kEthtool = "/usr/sbin/ethtool";
constexpr const char* kNamespaces = "/run/netns";
const std::string kPrefix = "coppice-";

std::vector<std::string> words(const std::string& line) {
  std::vector<std::string> result;
  for (std::size_t begin = 0; begin < line.size();) {
    const std::size_t end = std::min(line.find(' ', begin), line.size());
    result.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return result;
}

Completed try_ip(const std::string& arguments) { return run_to_end({.program = kIp, .arguments = words(arguments)}); }

void run(const Command& command, const std::string& input = {}) {
  const Completed completed = run_to_end(command, input);
  if (completed.ending.exit_code != 0) {
    throw std::runtime_error(fmt::format("{} {}: {}{}", command.program.string(), fmt::join(command.arguments, " "),
                                         completed.output, completed.error));
  }
}

void ip(const std::string& arguments) { run({.program = kIp, .arguments = words(arguments)}); }

// Namespaces of tests that did not live to take them away.
void remove_left_behind() {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(kNamespaces, ignored)) {
    const std::string name = entry.path().filename();
    if (name.starts_with(kPrefix)) {
      const auto owner = static_cast<pid_t>(std::strtol(name.c_str() + kPrefix.size(), nullptr, 10));
      if (owner > 0 && kill(owner, 0) != 0) {
        try_ip("netns del " + name);
      }
    }
  }
}

}  // namespace

std::optional<std::string> Hosts::why_not() {
  if (geteuid() != 0) {
    return "network namespaces need root";
  }
  for (const char* program : {kIp, kNft, kEthtool}) {
    if (access(program, X_OK) != 0) {
      return fmt::format("no {}: deploy/install-packages.sh tests installs it", program);
    }
  }
  const std::string name = fmt::format("{}{}-trial", kPrefix, getpid());
  Completed tried = try_ip("netns add " + name);
  if (tried.ending.exit_code == 0) {  // containers and changed roots may have it, and not let anybody in
    tried = try_ip(fmt::format("netns exec {} {} link add br0 type bridge", name, kIp));
  }
  try_ip("netns del " + name);
  if (tried.ending.exit_code != 0) {
    return "cannot make hosts of network namespaces: " + tried.error;
  }
  return std::nullopt;
}

Hosts::Hosts(std::size_t count) : prefix_(fmt::format("{}{}-", kPrefix, getpid())), count_(count) {
  remove_left_behind();
  const std::string sw = network_switch();
  ip("netns add " + sw);
  ip(fmt::format("-n {} link add br0 type bridge mcast_snooping 0", sw));
  ip(fmt::format("-n {} link set br0 up", sw));
  for (std::size_t host = 1; host <= count_; ++host) {
    ip("netns add " + name(host));
    ip(fmt::format("-n {} link set lo up", name(host)));
    ip(fmt::format("link add eth0 netns {} type veth peer name p{} netns {}", name(host), host, sw));
    ip(fmt::format("-n {} link set p{} master br0 up", sw, host));
    ip(fmt::format("-n {} addr add {}/24 dev eth0", name(host), address(host)));
    ip(fmt::format("-n {} link set eth0 up", name(host)));
  }
}

Hosts::~Hosts() {
  delays_.clear();
  for (std::size_t host = 1; host <= count_; ++host) {
    try_ip("netns del " + name(host));
  }
  try_ip("netns del " + network_switch());
}

Command Hosts::on(std::size_t host, Command command) const {
  std::vector<std::string> arguments = {"netns", "exec", name(host), command.program.string()};
  arguments.insert(arguments.end(), command.arguments.begin(), command.arguments.end());
  command.program = kIp;
  command.arguments = std::move(arguments);
  return command;
}

void Hosts::set_link(std::size_t host, bool up) const {
  ip(fmt::format("-n {} link set p{} {}", network_switch(), host, up ? "up" : "down"));
}

void Hosts::set_mtu(std::size_t host, int bytes) const {
  ip(fmt::format("-n {} link set eth0 mtu {}", name(host), bytes));
}

void Hosts::drop_fragments() const {
  run({.program = kIp, .arguments = {"netns", "exec", network_switch(), kNft, "-f", "-"}},
      "table bridge whole { chain pieces { type filter hook forward priority 0; policy accept;\n"
      "  ip frag-off & 0x3fff != 0 counter drop\n}\n}\n");
}

void Hosts::lose(int percent) const {
  run({.program = kIp, .arguments = {"netns", "exec", network_switch(), kNft, "-f", "-"}},
      fmt::format("table bridge lossy\nflush table bridge lossy\ntable bridge lossy {{ chain drops {{\n"
                  "  type filter hook forward priority 0; policy accept; numgen random mod 100 < {} counter drop\n"
                  "}}\n}}\n",
                  percent));
}

void Hosts::delay(std::size_t host, int milliseconds) {
  const std::string sw = network_switch();
  // p<host> leaves the bridge; a relay carries its packets to and from a second pair of ends that joins in its place.
  ip(fmt::format("-n {0} link set p{1} nomaster", sw, host));
  ip(fmt::format("-n {0} link add q{1} type veth peer name r{1}", sw, host));
  ip(fmt::format("-n {0} link set r{1} master br0 up", sw, host));
  ip(fmt::format("-n {0} link set q{1} up", sw, host));
  // A relayed packet must be whole: checksums and segments made by the sender, not left to a card.
  run({.program = kIp,
       .arguments = words(fmt::format("netns exec {} {} -K eth0 tx off tso off gso off", name(host), kEthtool))});
  for (std::size_t other = 1; other <= count_; ++other) {
    run({.program = kIp,
         .arguments = words(fmt::format("netns exec {} {} -K eth0 tx off tso off gso off", name(other), kEthtool))});
  }
  auto& relay = delays_[host];
  relay =
      std::make_unique<Process>(Command{.program = kIp,
                                        .arguments = {"netns", "exec", sw, COPPICE_SLOW_LINK, fmt::format("p{}", host),
                                                      fmt::format("q{}", host), std::to_string(milliseconds)}});
  relay->await_output("relaying");
}

void Hosts::hasten(std::size_t host) {
  const std::string sw = network_switch();
  delays_.erase(host);
  ip(fmt::format("-n {} link del q{}", sw, host));
  ip(fmt::format("-n {0} link set p{1} master br0", sw, host));
}

void Hosts::admit_only(std::size_t host, const std::string& rules) const {
  run({.program = kIp, .arguments = {"netns", "exec", name(host), kNft, "-f", "-"}},
      fmt::format("table inet firewall {{ chain inbound {{ type filter hook input priority 0; policy drop;\n"
                  "  iif lo accept; {}\n}}\n}}\n",
                  rules));
}

void Hosts::ip_on(std::size_t host, const std::string& arguments) const { ip("-n " + name(host) + " " + arguments); }

// Without duplicate address detection, which takes seconds.
void Hosts::use_ipv6_only() const {
  for (std::size_t host = 1; host <= count_; ++host) {
    ip_on(host, "-4 addr flush dev eth0");
    ip_on(host, fmt::format("addr add {}/64 dev eth0 nodad", address6(host)));
    ip_on(host, fmt::format("addr add {}/64 dev eth0 nodad", link_local(host)));
  }
}

void Hosts::hide_behind(std::size_t router, std::size_t hidden, int port) const {
  ip_on(hidden, "-4 addr flush dev eth0");
  ip_on(hidden, fmt::format("addr add 10.98.0.{}/24 dev eth0", hidden));
  ip_on(router, "addr add 10.98.0.254/24 dev eth0");
  ip_on(hidden, "route add default via 10.98.0.254");
  run({.program = kIp,
       .arguments = {"netns", "exec", name(router), "/bin/sh", "-c", "echo 1 > /proc/sys/net/ipv4/ip_forward"}});
  run({.program = kIp, .arguments = {"netns", "exec", name(router), kNft, "-f", "-"}},
      fmt::format("table ip nat {{\nchain arriving {{\ntype nat hook prerouting priority -100\n"
                  "ip daddr {0} udp dport {1} dnat to 10.98.0.{2}\n}}\n"
                  "chain leaving {{\ntype nat hook postrouting priority 100\n"
                  "ip saddr 10.98.0.0/24 ip daddr 10.99.0.0/24 masquerade\n}}\n}}\n",
                  address(router), port, hidden));
}

void Hosts::join_directly(std::size_t one, std::size_t other) const {
  ip(fmt::format("link add eth1 netns {} type veth peer name eth1 netns {}", name(one), name(other)));
  for (const std::size_t host : {one, other}) {
    ip_on(host, fmt::format("addr add 10.97.0.{}/24 dev eth1", host));
    ip_on(host, "link set eth1 up");
  }
}

}  // namespace coppice::e2e
