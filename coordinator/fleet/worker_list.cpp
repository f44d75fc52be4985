#include "coordinator/fleet/worker_list.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <tuple>

#include "common/wire/configuration.hpp"
#include "common/wire/credentials.hpp"
#include "common/wire/topics.hpp"
#include "common/wire/waiter.hpp"
#include "coordinator/fleet/port_holder.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLook{50};
constexpr std::size_t kMostListedPerTake = 4096;
constexpr std::size_t kMostListed = 65536;

WorkerList sorted(WorkerList list) {
  std::sort(list.workers.begin(), list.workers.end(), [](const ListedWorker& a, const ListedWorker& b) {
    return std::tie(a.host, a.pid) < std::tie(b.host, b.pid);
  });
  return list;
}

// Takes samples until the time is over, on_look() returns true, or `stop` is raised.
template <typename Sample, typename OnSample>
Result<bool> listen(const wire::Participant& participant, Clock::time_point end, const StopFlag& stop,
                    const OnSample& on_sample) {
  auto reader = wire::Reader<Sample>::make(participant);
  if (!reader) {
    return tl::unexpected(reader.error());
  }
  auto waiter = wire::Waiter::make(participant);
  if (!waiter) {
    return tl::unexpected(waiter.error());
  }
  if (auto ok = waiter->watch_reader(reader->get()); !ok) {
    return tl::unexpected(ok.error());
  }
  bool enough = false;
  while (!enough && Clock::now() < end) {
    if (stop.raised()) {
      return interrupted();
    }
    reader->take(kMostListedPerTake, [&](const Sample& sample, const dds_sample_info_t& info) {
      enough = on_sample(sample, info) || enough;
    });
    if (!enough) {
      waiter->wait(kLook);
    }
  }
  return enough;
}

// In the coordinator's place, without a run to offer: workers say Hello and go on waiting.
Result<WorkerList> hear_workers(const WorkerListOptions& options, const StopFlag& stop) {
  const wire::Network network{.security = options.security, .lossy = false, .advertise = {}, .port = std::nullopt};
  const auto participant = wire::Participant::join(
      options.domain, wire::coordinator_configuration(options.interface.empty() ? "lo" : options.interface, network));
  if (!participant) {
    return tl::unexpected(participant.error());
  }
  struct Heard {
    wire::WorkerStatus status;
    Clock::time_point at;
  };
  std::map<std::uint64_t, Heard> heard;
  const auto listened = listen<wire::Hello>(*participant, Clock::now() + kListeningTime, stop,
                                            [&](const wire::Hello& hello, const dds_sample_info_t& info) {
                                              if (!info.valid_data || hello.leaving) {
                                                heard.erase(hello.worker);
                                              } else if (heard.size() < kMostListed) {
                                                heard[hello.worker] = {wire::status_of(hello), Clock::now()};
                                              }
                                              return false;
                                            });
  if (!listened) {
    return tl::unexpected(listened.error());
  }
  WorkerList list;
  for (auto& [id, worker] : heard) {
    const auto since = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - worker.at);
    worker.status.seen_ms = static_cast<std::uint32_t>(since.count());
    list.workers.push_back(listed(worker.status, "waiting for a coordinator"));
  }
  return sorted(std::move(list));
}

Result<std::optional<WorkerList>> ask_coordinator(const std::string& host, const WorkerListOptions& options,
                                                  const StopFlag& stop) {
  const wire::Network network{.security = options.security, .lossy = false, .advertise = {}, .port = options.port};
  const auto configuration = wire::worker_configuration(host, options.domain, network);
  if (!configuration) {
    return tl::unexpected(configuration.error());
  }
  const auto participant = wire::Participant::join(options.domain, *configuration);
  if (!participant) {
    return tl::unexpected(participant.error());
  }
  WorkerList list;
  const auto answered = listen<wire::Fleet>(*participant, Clock::now() + options.patience, stop,
                                            [&](const wire::Fleet& fleet, const dds_sample_info_t& info) {
                                              if (!info.valid_data) {
                                                return false;
                                              }
                                              list.coordinator = {.host = wire::shown(fleet.host),
                                                                  .pid = fleet.pid,
                                                                  .version = wire::shown(fleet.version),
                                                                  .chain = wire::from_wire(fleet.chain).hex()};
                                              list.workers.clear();
                                              for (std::uint32_t i = 0; i < fleet.workers._length; ++i) {
                                                const wire::WorkerStatus& status = fleet.workers._buffer[i];
                                                list.workers.push_back(listed(status));
                                              }
                                              return true;
                                            });
  if (!answered) {
    return tl::unexpected(answered.error());
  }
  return *answered ? std::optional(sorted(std::move(list))) : std::nullopt;
}

}  // namespace

Result<WorkerList> list_workers(const WorkerListOptions& options, const StopFlag& stop) {
  if (!options.security.empty()) {
    if (auto ok = wire::check_credentials(options.security); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  if (!options.interface.empty()) {
    if (auto ok = wire::check_interface(options.interface); !ok) {
      return in_context("--interface", ok.error());
    }
  }
  std::vector<std::string> hosts = {options.coordinator};
  if (options.coordinator.empty()) {
    const auto holder = udp_port_holder(wire::coordinator_port(options.domain));
    if (!holder) {
      return hear_workers(options, stop);
    }
    hosts = wire::addresses_of(options.interface);  // where a coordinator of this machine may listen
    std::erase_if(hosts,
                  [&](const std::string& host) { return (host.find(':') != std::string::npos) != holder->ipv6; });
  }
  for (const std::string& host : hosts) {
    auto list = ask_coordinator(host, options, stop);
    if (!list) {
      return tl::unexpected(list.error());
    }
    if (*list) {
      return std::move(**list);
    }
  }
  const auto holder =
      options.coordinator.empty() ? udp_port_holder(wire::coordinator_port(options.domain)) : std::nullopt;
  return failed(fmt::format(
      "no coordinator answers in domain {} at {} (UDP port {}{}). One that is not evaluating just now does not answer; "
      "one under DDS Security answers only to --security",
      options.domain, fmt::join(hosts, ", "), wire::coordinator_port(options.domain),
      holder ? ", held by " + in_words(*holder) : ""));
}

}  // namespace coppice
