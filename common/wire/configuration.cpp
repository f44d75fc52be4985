#include "common/wire/configuration.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <memory>
#include <net/if.h>
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
// A worker announces itself twice a second, so that a coordinator that comes back finds it within a second.
constexpr const char* kWorkerDiscovery = "<SPDPInterval>500ms</SPDPInterval><LeaseDuration>10s</LeaseDuration>";

// Small packets are repaired one by one, and soon: at 1 % loss this carries 39 MB/s, the defaults 10.
constexpr const char* kQuickRepair =
    "<NackDelay>1ms</NackDelay><AckDelay>1ms</AckDelay><PreEmptiveAckDelay>1ms</PreEmptiveAckDelay>"
    "<HeartbeatInterval min=\"1ms\" minsched=\"5ms\" max=\"1s\">20ms</HeartbeatInterval>";
constexpr int kSmallFragment = kSmallPacket - 128;  // what a packet carries beside RTPS headers

// In numbers; a link-local one with the interface that it belongs to ("fe80::1%eth0") if `scoped`: a machine has one
// network of that name on every interface.
std::string text_of(const SocketAddress& address, bool scoped) {
  char text[INET6_ADDRSTRLEN] = {};
  if (address.storage.ss_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address.storage, sizeof v4);
    inet_ntop(AF_INET, &v4.sin_addr, text, sizeof text);
    return text;
  }
  sockaddr_in6 v6{};
  std::memcpy(&v6, &address.storage, sizeof v6);
  inet_ntop(AF_INET6, &v6.sin6_addr, text, sizeof text);
  char name[IF_NAMESIZE] = {};
  return scoped && v6.sin6_scope_id != 0 && if_indextoname(v6.sin6_scope_id, name) != nullptr
             ? fmt::format("{}%{}", text, name)
             : std::string(text);
}

std::string without_scope(const std::string& address) { return address.substr(0, address.find('%')); }

// AF_INET, AF_INET6, or AF_UNSPEC: no address in numbers.
int family_of(const std::string& text) {
  std::array<std::uint8_t, sizeof(in6_addr)> address{};
  return inet_pton(AF_INET, text.c_str(), address.data()) == 1                   ? AF_INET
         : inet_pton(AF_INET6, without_scope(text).c_str(), address.data()) == 1 ? AF_INET6
                                                                                 : AF_UNSPEC;
}

std::string interface_element(const std::string& interface) {
  return fmt::format("<Interfaces><NetworkInterface {}=\"{}\"/></Interfaces>",
                     family_of(interface) != AF_UNSPEC ? "address" : "name", without_scope(interface));
}

std::string general_element(const std::string& interface, int family, const Network& network) {
  return fmt::format("<General>{}{}{}<AllowMulticast>false</AllowMulticast>{}</General>", interface_element(interface),
                     family == AF_INET6 ? "<Transport>udp6</Transport>" : "",
                     network.advertise.empty()
                         ? std::string()
                         : fmt::format("<ExternalNetworkAddress>{}</ExternalNetworkAddress>", network.advertise),
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

// The local address that the machine's routes choose towards `peer`; no packet is sent.
Result<SocketAddress> local_address_towards(const SocketAddress& peer) {
  const int socket_fd = socket(peer.storage.ss_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_fd < 0) {
    return failed("cannot open a UDP socket");
  }
  SocketAddress from;
  from.length = sizeof from.storage;
  const bool reached = connect(socket_fd, reinterpret_cast<const sockaddr*>(&peer.storage), peer.length) == 0 &&
                       getsockname(socket_fd, reinterpret_cast<sockaddr*>(&from.storage), &from.length) == 0;
  const int error = errno;
  close(socket_fd);
  if (reached) {
    return from;
  }
  const std::string text = text_of(peer, true);
  if (error == EINVAL && text.rfind("fe80", 0) == 0) {
    return failed(
        fmt::format("the coordinator's address {} is link-local: expected the interface that leads there with "
                    "it, as {}%eth0",
                    text, text));
  }
  return failed(fmt::format("no route to the coordinator at {}", text));
}

struct Interface {
  std::string name;
  std::string address;
  int family = AF_UNSPEC;
};

// IPv4 first, link-local last.
std::vector<Interface> interfaces() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) {
    return {};
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, &freeifaddrs);
  std::vector<Interface> found;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    const int family = entry->ifa_addr != nullptr ? entry->ifa_addr->sa_family : AF_UNSPEC;
    if (family == AF_INET || family == AF_INET6) {
      SocketAddress address;
      std::memcpy(&address.storage, entry->ifa_addr, family == AF_INET ? sizeof(sockaddr_in) : sizeof(sockaddr_in6));
      found.push_back({entry->ifa_name, text_of(address, true), family});
    }
  }
  const auto rank = [](const Interface& one) {
    return one.family == AF_INET ? 0 : one.address.find('%') == std::string::npos ? 1 : 2;
  };
  std::stable_sort(found.begin(), found.end(),
                   [&](const Interface& one, const Interface& other) { return rank(one) < rank(other); });
  return found;
}

bool is_meant(const Interface& known, const std::string& interface) {
  return interface == known.name || interface == known.address || interface == without_scope(known.address);
}

// That a coordinator uses on an interface: IPv4 where there is any, unless an address says otherwise.
int family_on(const std::string& interface) {
  for (const Interface& known : interfaces()) {
    if (is_meant(known, interface)) {
      return known.family;
    }
  }
  return AF_INET;
}

}  // namespace

Result<SocketAddress> coordinator_address(const std::string& host, std::uint32_t domain) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(coordinator_port(domain));
  if (const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); error != 0) {
    return bad_input(fmt::format("coordinator '{}' does not resolve to an address: {}", host, gai_strerror(error)));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, &freeaddrinfo);
  const addrinfo* chosen = found;  // a coordinator uses IPv4 where it has both
  for (const addrinfo* entry = found; entry != nullptr; entry = entry->ai_next) {
    if (entry->ai_family == AF_INET) {
      chosen = entry;
      break;
    }
  }
  SocketAddress result;
  std::memcpy(&result.storage, chosen->ai_addr, chosen->ai_addrlen);
  result.length = chosen->ai_addrlen;
  return result;
}

std::string coordinator_configuration(const std::string& interface, const Network& network) {
  // Linger 0: deleting the writer of a dead worker must not block the coordinator for a second.
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\">{}"
      "<Discovery><Ports><UnicastDataOffset>10</UnicastDataOffset></Ports>"
      "<ParticipantIndex>0</ParticipantIndex><MaxAutoParticipantIndex>0</MaxAutoParticipantIndex>{}</Discovery>"
      "<Internal><WriterLingerDuration>0s</WriterLingerDuration>{}</Internal>{}</Domain></CycloneDDS>",
      general_element(interface, family_on(interface), network), kDiscovery, network.lossy ? kQuickRepair : "",
      security_element(network));
}

Result<std::string> worker_configuration(const std::string& coordinator_host, std::uint32_t domain,
                                         const Network& network) {
  const auto peer = coordinator_address(coordinator_host, domain);
  if (!peer) {
    return tl::unexpected(peer.error());
  }
  const auto local = local_address_towards(*peer);
  if (!local) {
    return tl::unexpected(local.error());
  }
  const bool v6 = peer->storage.ss_family == AF_INET6;
  // A port of one's own choosing: the one that participant 0 of a domain without gains has.
  const std::string own_port =
      network.port ? fmt::format(
                         "<Ports><Base>{}</Base><DomainGain>0</DomainGain><ParticipantGain>0</ParticipantGain>"
                         "<UnicastMetaOffset>0</UnicastMetaOffset><UnicastDataOffset>0</UnicastDataOffset>"
                         "</Ports><ParticipantIndex>0</ParticipantIndex>",
                         *network.port)
                   : "<ParticipantIndex>none</ParticipantIndex>";
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\">{}<Discovery>{}{}<Peers><Peer Address=\"{}\"/></Peers></Discovery>"
      "<Internal>{}</Internal>{}</Domain></CycloneDDS>",
      general_element(text_of(*local, false), peer->storage.ss_family, network), own_port, kWorkerDiscovery,
      fmt::format("{}{}{}:{}", v6 ? "[" : "", text_of(*peer, false), v6 ? "]" : "", coordinator_port(domain)),
      network.lossy ? kQuickRepair : "", security_element(network));
}

std::vector<std::string> addresses_of(const std::string& interface) {
  std::vector<std::string> addresses;
  for (const Interface& known : interfaces()) {
    if (interface.empty() || is_meant(known, interface)) {
      addresses.push_back(known.address);
    }
  }
  return addresses;
}

Result<void> check_advertised(const std::string& address, const std::string& interface) {
  const int family = family_of(address);
  if (family == AF_UNSPEC || family != family_on(interface)) {
    return bad_input(fmt::format("--advertise is {}: expected an {} address in numbers, as --interface {} has one",
                                 address, family_on(interface) == AF_INET6 ? "IPv6" : "IPv4", interface));
  }
  return {};
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
