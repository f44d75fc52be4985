#include "coordinator/fleet/endpoints.hpp"

#include <chrono>
#include <fmt/format.h>
#include <thread>
#include <unistd.h>

#include "common/wire/credentials.hpp"
#include "coordinator/fleet/port_holder.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kLocalDomains = 200;  // domains 1..200 are for local runs, 0 is the default for others

constexpr const char* kListingCommand = "coppice workers";  // in its command line
constexpr std::chrono::seconds kListingTime{6};
constexpr std::chrono::milliseconds kListingInterval{20};

// The nearest above whose port nobody holds, for a message.
std::uint32_t next_free(std::uint32_t domain) {
  for (std::uint32_t i = 1; i <= wire::kMaxDomain; ++i) {
    const std::uint32_t other = (domain + i) % (wire::kMaxDomain + 1);
    if (!udp_port_holder(wire::coordinator_port(other))) {
      return other;
    }
  }
  return domain;
}

template <typename T>
Result<void> keep_error(const Result<T>& result, const Result<void>& so_far) {
  return so_far && !result ? Result<void>(tl::unexpected(result.error())) : so_far;
}

// A `coppice workers` that lists workers without a coordinator lets go of the port within seconds; others keep it.
Result<void> await_free(std::uint32_t domain) {
  const std::uint32_t port = wire::coordinator_port(domain);
  const auto end = std::chrono::steady_clock::now() + kListingTime;
  auto holder = udp_port_holder(port);
  while (holder && holder->command.find(kListingCommand) != std::string::npos &&
         std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(kListingInterval);
    holder = udp_port_holder(port);
  }
  if (holder) {
    return failed(
        fmt::format("domain {} is taken on this machine: its UDP port {} is held by {}. Choose another domain, "
                    "for this and its workers: --domain {}",
                    domain, port, in_words(*holder), next_free(domain)));
  }
  return {};
}

struct Joined {
  std::uint32_t domain;
  wire::Participant participant;
};

Result<Joined> join(const std::optional<std::uint32_t>& domain, const std::string& interface,
                    const wire::Network& network) {
  if (auto ok = Endpoints::check(interface, network); !ok) {
    return tl::unexpected(ok.error());
  }
  const std::string configuration = wire::coordinator_configuration(interface, network);
  if (domain) {
    if (auto ok = await_free(*domain); !ok) {
      return tl::unexpected(ok.error());
    }
    auto participant = wire::Participant::join(*domain, configuration);
    if (!participant) {
      return failed(fmt::format("domain {} cannot be used (UDP port {}); choose another with --domain: {}", *domain,
                                wire::coordinator_port(*domain), participant.error().message));
    }
    return Joined{*domain, std::move(*participant)};
  }
  // Starting at a place that depends on the process, so that two runs seldom try the same.
  std::string last;
  for (std::uint32_t i = 0; i < kLocalDomains; ++i) {
    const std::uint32_t local = 1 + (static_cast<std::uint32_t>(getpid()) + i) % kLocalDomains;
    auto participant = wire::Participant::join(local, configuration);
    if (participant) {
      return Joined{local, std::move(*participant)};
    }
    last = participant.error().message;
  }
  return failed(fmt::format("no DDS domain of 1 to {} is free on this machine: {}", kLocalDomains, last));
}

}  // namespace

Result<void> Endpoints::check(const std::string& interface, const wire::Network& network) {
  if (auto ok = wire::check_interface(interface); !ok) {
    return in_context("--interface", ok.error());
  }
  if (!network.advertise.empty()) {
    if (auto ok = wire::check_advertised(network.advertise, interface); !ok) {
      return ok;
    }
  }
  return network.security.empty() ? Result<void>{} : wire::check_credentials(network.security);
}

Result<Endpoints> Endpoints::open(const std::optional<std::uint32_t>& domain, const std::string& interface,
                                  const wire::Network& network) {
  auto joined = join(domain, interface, network);
  if (!joined) {
    return tl::unexpected(joined.error());
  }
  const wire::Participant& participant = joined->participant;
  auto waiter = wire::Waiter::make(participant);
  auto hellos = wire::Reader<wire::Hello>::make(participant);
  auto answers = wire::Reader<wire::Answer>::make(participant);
  auto requests = wire::Reader<wire::ChainRequest>::make(participant);
  auto control = wire::Writer<wire::Control>::make(participant);
  auto fleet = wire::Writer<wire::Fleet>::make(participant);
  Result<void> ok = keep_error(fleet, Result<void>{});
  ok = keep_error(control, keep_error(requests, keep_error(answers, keep_error(hellos, keep_error(waiter, ok)))));
  if (ok) {
    for (const dds_entity_t reader : {hellos->get(), answers->get(), requests->get()}) {
      ok = keep_error(waiter->watch_reader(reader), ok);
    }
  }
  if (!ok) {
    return tl::unexpected(ok.error());
  }
  return Endpoints{joined->domain,
                   std::move(joined->participant),
                   std::move(*waiter),
                   std::move(*hellos),
                   std::move(*answers),
                   std::move(*requests),
                   std::move(*control),
                   std::move(*fleet),
                   {}};
}

}  // namespace coppice
