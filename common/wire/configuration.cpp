#include "common/wire/configuration.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <cstring>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <memory>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

#include "common/wire/credentials.hpp"

namespace coppice::wire {
namespace {

// Participant lease: long, because short leases on an overloaded machine make libddsc 0.10 drop healthy peers;
// the worker's own liveliness (topics.cpp) is what notices a death quickly.
constexpr const char* kDiscovery = "<SPDPInterval>1s</SPDPInterval><LeaseDuration>10s</LeaseDuration>";
// A worker knocks so often that a coordinator has it within a second of its return.
constexpr const char* kWorkerDiscovery = "<SPDPInterval>500ms</SPDPInterval><LeaseDuration>10s</LeaseDuration>";

// Small packets are repaired one by one, and soon: at 1 % loss this carries 39 MB/s, the defaults 10.
constexpr const char* kQuickRepair =
    "<NackDelay>1ms</NackDelay><AckDelay>1ms</AckDelay><PreEmptiveAckDelay>1ms</PreEmptiveAckDelay>"
    "<HeartbeatInterval min=\"1ms\" minsched=\"5ms\" max=\"1s\">20ms</HeartbeatInterval>";
constexpr int kSmallFragment = kSmallPacket - 128;  // what a packet carries beside RTPS headers

std::string address_text(const in_addr& address) {
  char text[INET_ADDRSTRLEN] = {};
  inet_ntop(AF_INET, &address, text, sizeof text);
  return text;
}

bool is_address(const std::string& text) {
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

std::string interface_element(const std::string& interface) {
  return fmt::format("<Interfaces><NetworkInterface {}=\"{}\"/></Interfaces>",
                     is_address(interface) ? "address" : "name", interface);
}

std::string general_element(const std::string& interface, const Network& network) {
  return fmt::format("<General>{}<AllowMulticast>false</AllowMulticast>{}</General>", interface_element(interface),
                     network.lossy ? fmt::format("<MaxMessageSize>{}B</MaxMessageSize><FragmentSize>{}B</FragmentSize>",
                                                 kSmallPacket, kSmallFragment)
                                   : "");
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string security_element(const Network& network) {
  if (network.security.empty()) {
    return "";
  }
  const auto file = [&](const char* name) {
    return "file:" + escaped(std::filesystem::absolute(network.security / name).string());
  };
  std::error_code error;
  const std::string revoked = std::filesystem::exists(network.security / kRevoked, error)
                                  ? fmt::format("<CRL>{}</CRL>", file(kRevoked))
                                  : std::string();
  return fmt::format(
      "<Security><Authentication><IdentityCA>{}</IdentityCA><IdentityCertificate>{}</IdentityCertificate>"
      "<PrivateKey>{}</PrivateKey>{}</Authentication>"
      "<AccessControl><PermissionsCA>{}</PermissionsCA><Governance>{}</Governance><Permissions>{}</Permissions>"
      "</AccessControl><Cryptographic/></Security>",
      file(kIdentityAuthority), file(kCertificate), file(kPrivateKey), revoked, file(kPermissionsAuthority),
      file(kGovernance), file(kPermissions));
}

Result<in_addr> resolve(const std::string& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), nullptr, &hints, &found); error != 0) {
    return bad_input(
        fmt::format("coordinator '{}' does not resolve to an IPv4 address: {}", host, gai_strerror(error)));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, &freeaddrinfo);
  sockaddr_in address{};
  std::memcpy(&address, found->ai_addr, sizeof address);
  return address.sin_addr;
}

// The local address that the machine's routes choose towards `peer`; no packet is sent.
Result<in_addr> local_address_towards(const in_addr& peer) {
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_fd < 0) {
    return failed("cannot open a UDP socket");
  }
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(coordinator_port(0)));
  to.sin_addr = peer;
  sockaddr_in from{};
  socklen_t length = sizeof from;
  const bool reached = connect(socket_fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
                       getsockname(socket_fd, reinterpret_cast<sockaddr*>(&from), &length) == 0;
  close(socket_fd);
  if (!reached) {
    return failed(fmt::format("no route to the coordinator at {}", address_text(peer)));
  }
  return from.sin_addr;
}

}  // namespace

std::string coordinator_configuration(const std::string& interface, const Network& network) {
  // Linger 0: deleting the writer of a dead worker must not block the coordinator for a second.
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\">{}"
      "<Discovery><Ports><UnicastDataOffset>10</UnicastDataOffset></Ports>"
      "<ParticipantIndex>0</ParticipantIndex><MaxAutoParticipantIndex>0</MaxAutoParticipantIndex>{}</Discovery>"
      "<Internal><WriterLingerDuration>0s</WriterLingerDuration>{}</Internal>{}</Domain></CycloneDDS>",
      general_element(interface, network), kDiscovery, network.lossy ? kQuickRepair : "", security_element(network));
}

Result<std::string> worker_configuration(const std::string& coordinator_host, std::uint32_t domain,
                                         const Network& network) {
  const auto peer = resolve(coordinator_host);
  if (!peer) {
    return tl::unexpected(peer.error());
  }
  const auto local = local_address_towards(*peer);
  if (!local) {
    return tl::unexpected(local.error());
  }
  // A port of one's own choosing: the one that participant 0 of a domain without gains has.
  const std::string own_port =
      network.port ? fmt::format(
                         "<Ports><Base>{}</Base><DomainGain>0</DomainGain><ParticipantGain>0</ParticipantGain>"
                         "<UnicastMetaOffset>0</UnicastMetaOffset><UnicastDataOffset>0</UnicastDataOffset>"
                         "</Ports><ParticipantIndex>0</ParticipantIndex>",
                         *network.port)
                   : "<ParticipantIndex>none</ParticipantIndex>";
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\">{}<Discovery>{}{}<Peers><Peer Address=\"{}:{}\"/></Peers></Discovery>"
      "<Internal>{}</Internal>{}</Domain></CycloneDDS>",
      general_element(address_text(*local), network), own_port, kWorkerDiscovery, address_text(*peer),
      coordinator_port(domain), network.lossy ? kQuickRepair : "", security_element(network));
}

namespace {

struct Interface {
  std::string name;
  std::string address;
};

// Those with an IPv4 address.
std::vector<Interface> interfaces() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) {
    return {};
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, &freeifaddrs);
  std::vector<Interface> found;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr != nullptr && entry->ifa_addr->sa_family == AF_INET) {
      sockaddr_in address{};
      std::memcpy(&address, entry->ifa_addr, sizeof address);
      found.push_back({entry->ifa_name, address_text(address.sin_addr)});
    }
  }
  return found;
}

}  // namespace

std::vector<std::string> addresses_of(const std::string& interface) {
  std::vector<std::string> addresses;
  for (const Interface& known : interfaces()) {
    if (interface.empty() || interface == known.name || interface == known.address) {
      addresses.push_back(known.address);
    }
  }
  return addresses;
}

Result<void> check_interface(const std::string& interface) {
  if (!interface.empty() && !addresses_of(interface).empty()) {
    return {};
  }
  std::vector<std::string> known;
  for (const Interface& one : interfaces()) {
    known.push_back(fmt::format("{} ({})", one.name, one.address));
  }
  return bad_input(
      fmt::format("no network interface '{}' on this machine: expected one of {}", interface, fmt::join(known, ", ")));
}

}  // namespace coppice::wire
