#include "coordinator/fleet/onlookers.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>
#include <vector>

#include "common/version.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr auto kShowInterval = 500ms;
constexpr auto kPaceWindow = 1s;
constexpr auto kMemory = 10s;  // of workers that are not served, since they were heard
constexpr std::size_t kMostSeen = coppice_wire_MAX_LISTED;
static_assert(Roster::kMaxWorkers < kMostSeen);

coppice_wire_Doing doing_of_outcast(const Roster& roster, WorkerId id, const wire::WorkerStatus& status) {
  if (roster.is_banned(id)) {
    return coppice_wire_QUARANTINED;
  }
  return status.protocol != wire::kProtocolVersion ? coppice_wire_REFUSED_VERSION : coppice_wire_REFUSED_BUILD;
}

}  // namespace

void Onlookers::hear(const wire::Hello& hello, Time now) {
  const WorkerId id{hello.worker};
  if (hello.leaving) {
    seen_.erase(id);
    return;
  }
  if (seen_.size() >= kMostSeen && seen_.count(id) == 0) {
    return;
  }
  Seen& seen = seen_[id];
  seen.status = wire::status_of(hello);
  seen.heard = now;
  if (const auto window = now - seen.counting_since; window >= kPaceWindow) {
    const auto seconds = std::chrono::duration<double>(window).count();
    const bool counts = seen.counting_since != Time{} && hello.evaluated >= seen.counted;
    seen.each_second =
        counts ? static_cast<std::uint64_t>(static_cast<double>(hello.evaluated - seen.counted) / seconds) : 0;
    seen.counting_since = now;
    seen.counted = hello.evaluated;
  }
}

std::vector<wire::WorkerStatus> Onlookers::workers(const Dispatcher& dispatcher, Time now) const {
  std::vector<wire::WorkerStatus> workers;
  workers.reserve(seen_.size());
  for (const auto& [id, seen] : seen_) {
    const KnownWorker* const known = dispatcher.roster().find(id);
    if (known == nullptr && !dispatcher.roster().is_banned(id) && !dispatcher.roster().is_refused(id)) {
      continue;  // gone
    }
    wire::WorkerStatus status = seen.status;
    const std::size_t batches = dispatcher.flight().load(id);
    status.doing = known == nullptr      ? doing_of_outcast(dispatcher.roster(), id, seen.status)
                   : !known->holds_chain ? coppice_wire_FETCHING
                   : batches > 0         ? coppice_wire_EVALUATING
                                         : coppice_wire_READY;
    status.batches = static_cast<std::uint32_t>(batches);
    status.each_second = seen.each_second;
    status.seen_ms =
        static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::milliseconds>(now - seen.heard).count());
    workers.push_back(status);
  }
  return workers;
}

void Onlookers::show(Endpoints& dds, const RunIdentity& run, const Dispatcher& dispatcher, Time now) {
  if (now < next_show_) {
    return;
  }
  next_show_ = now + kShowInterval;
  std::erase_if(seen_, [&](const auto& entry) {
    return now - entry.second.heard > kMemory && dispatcher.roster().find(entry.first) == nullptr;
  });
  if (watch_) {
    std::vector<ListedWorker> shown;
    for (const wire::WorkerStatus& status : workers(dispatcher, now)) {
      shown.push_back(listed(status));
    }
    watch_(shown);
  }
  if (!dds.fleet.matched()) {
    return;
  }
  std::vector<wire::WorkerStatus> workers = this->workers(dispatcher, now);
  wire::Fleet fleet{};
  fleet.protocol = wire::kProtocolVersion;
  fleet.run_id = run.run_id;
  wire::put_text(fleet.version, kVersion);
  wire::put_text(fleet.host, wire::host_name());
  fleet.pid = static_cast<std::uint32_t>(getpid());
  fleet.chain = wire::to_wire(run.chain);
  fleet.workers._buffer = workers.data();
  fleet.workers._length = fleet.workers._maximum = static_cast<std::uint32_t>(workers.size());
  if (auto ok = dds.fleet.write(fleet); !ok) {
    spdlog::debug("those who look on were not told: {}", ok.error().message);
  }
}

}  // namespace coppice
