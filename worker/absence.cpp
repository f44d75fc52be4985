#include "worker/absence.hpp"

#include <algorithm>
#include <cerrno>
#include <fmt/format.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>

#include "common/wire/configuration.hpp"

namespace coppice {
namespace {

constexpr std::chrono::seconds kFirst{10};
constexpr std::chrono::seconds kLongest{3600};
constexpr int kEcho = 200;  // milliseconds that a refusal takes at most, across a continent

struct Knocked {
  Absence::Knock how = Absence::Knock::silence;
  std::string error;
};

// An empty datagram; where nothing listens the host says so (ICMP), unless a firewall keeps silent.
Knocked knock(const ServeOptions& options) {
  using Knock = Absence::Knock;
  const auto peer = wire::coordinator_address(options.coordinator, options.domain);
  if (!peer) {
    return {Knock::cannot_be_sent, peer.error().message};
  }
  const int door = socket(peer->storage.ss_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const auto* const address = reinterpret_cast<const sockaddr*>(&peer->storage);
  int error = 0;
  if (door < 0 || connect(door, address, peer->length) != 0 || send(door, "", 0, MSG_NOSIGNAL) < 0) {
    error = errno;
  } else {
    pollfd wait{.fd = door, .events = 0, .revents = 0};  // errors always count
    if (poll(&wait, 1, kEcho) > 0) {
      socklen_t length = sizeof error;
      getsockopt(door, SOL_SOCKET, SO_ERROR, &error, &length);
    }
  }
  if (door >= 0) {
    close(door);
  }
  return {error == 0              ? Knock::silence
          : error == ECONNREFUSED ? Knock::nothing_listens
                                  : Knock::cannot_be_sent,
          error == 0 ? std::string() : std::generic_category().message(error)};
}

}  // namespace

void Absence::somebody() {
  since_ = Clock::now();
  next_ = kFirst;
}

void Absence::nobody(const std::function<std::size_t()>& met) {
  const auto alone = Clock::now() - since_;
  if (alone < next_) {
    return;
  }
  const Knocked knocked = knock(options_);
  spdlog::warn("no coordinator at {} (UDP port {}) for {} s: {}", options_.coordinator,
               wire::coordinator_port(options_.domain), std::chrono::duration_cast<std::chrono::seconds>(alone).count(),
               likely_cause(knocked.how, met(), options_, knocked.error));
  // Three times as long as before, but at least once an hour.
  next_ = std::chrono::duration_cast<std::chrono::seconds>(alone) +
          std::min<std::chrono::seconds>(2 * std::chrono::duration_cast<std::chrono::seconds>(alone), kLongest);
}

std::string Absence::likely_cause(Knock knock, std::size_t met, const ServeOptions& options, const std::string& error) {
  const bool secured = !options.network.security.empty();
  const std::string rights =
      secured ? "an identity that it does not know, that was revoked or that ended, or no --security there"
              : "--security there and not here";
  if (knock == Knock::nothing_listens) {
    return fmt::format(
        "nothing listens there: none runs just now, or in another --domain than {}, or on another "
        "--interface",
        options.domain);
  }
  if (knock == Knock::cannot_be_sent) {
    return fmt::format("it cannot be reached: {}", error);
  }
  if (met > 0) {
    return fmt::format(
        "a program of this DDS domain answers, but none that coordinates this version: {}, or a DDS "
        "application of somebody else",
        rights);
  }
  return fmt::format(
      "it neither answers nor refuses: a firewall (UDP port {} there, {} here), {}, --lossy on one side only, or a "
      "host "
      "that is down",
      wire::coordinator_port(options.domain),
      options.network.port ? fmt::format("{}", *options.network.port) : std::string("and any: give --port to open one"),
      rights);
}

}  // namespace coppice
