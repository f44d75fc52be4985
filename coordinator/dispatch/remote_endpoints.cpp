#include "coordinator/dispatch/remote_endpoints.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "common/wire/credentials.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kLocalDomains = 200;  // domains 1..200 are for local runs, 0 is the default for others

template <typename T>
Result<void> keep_error(const Result<T>& result, const Result<void>& so_far) {
  return so_far && !result ? Result<void>(tl::unexpected(result.error())) : so_far;
}

struct Joined {
  std::uint32_t domain;
  wire::Participant participant;
};

Result<Joined> join(const std::optional<std::uint32_t>& domain, const std::string& interface,
                    const wire::Network& network) {
  if (auto ok = RemoteEndpoints::check(interface, network); !ok) {
    return tl::unexpected(ok.error());
  }
  const std::string configuration = wire::coordinator_configuration(interface, network);
  if (domain) {
    auto participant = wire::Participant::join(*domain, configuration);
    if (!participant) {
      return failed(
          fmt::format("domain {} cannot be used (UDP port {}; is another coordinator on this machine? choose "
                      "another with --domain): {}",
                      *domain, wire::coordinator_port(*domain), participant.error().message));
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

Result<void> RemoteEndpoints::check(const std::string& interface, const wire::Network& network) {
  if (auto ok = wire::check_interface(interface); !ok) {
    return in_context("--interface", ok.error());
  }
  return network.security.empty() ? Result<void>{} : wire::check_credentials(network.security);
}

Result<RemoteEndpoints> RemoteEndpoints::open(const std::optional<std::uint32_t>& domain,
                                              const std::string& interface, const wire::Network& network) {
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
  Result<void> ok = keep_error(
      control, keep_error(requests, keep_error(answers, keep_error(hellos, keep_error(waiter, Result<void>{})))));
  if (ok) {
    for (const dds_entity_t reader : {hellos->get(), answers->get(), requests->get()}) {
      ok = keep_error(waiter->watch_reader(reader), ok);
    }
  }
  if (!ok) {
    return tl::unexpected(ok.error());
  }
  return RemoteEndpoints{joined->domain,      std::move(joined->participant), std::move(*waiter), std::move(*hellos),
                         std::move(*answers), std::move(*requests),           std::move(*control)};
}

}  // namespace coppice
