#include "coordinator/dispatch/remote_fleet.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "common/version.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr auto kNoticeInterval = 10s;  // "waiting for a worker" is repeated this often
constexpr auto kHangLimit = 5s;        // no progress with work at hand for this long, doubled each time
constexpr auto kLongestHangLimit = 3600s;
constexpr int kHangFactor = 4;  // times the measured cost of an individual, if that is longer
constexpr std::size_t kMaxWorkers = 1024;
constexpr auto kShowInterval = 500ms;
constexpr auto kOutcastMemory = 10s;  // since it was heard
constexpr std::size_t kMaxOutcasts = 256;
static_assert(kMaxWorkers + kMaxOutcasts <= coppice_wire_MAX_LISTED);
constexpr std::size_t kMaxRemembered = 4096;  // sources that were logged

}  // namespace

RemoteFleet::RemoteFleet(RemoteEndpoints& dds, const RunIdentity& run, InFlight& flight, DispatchStatistics& statistics)
    : dds_(dds), run_(run), flight_(flight), statistics_(statistics), hang_limit_(kHangLimit) {}

void RemoteFleet::begin() {
  hang_limit_ = kHangLimit;
  without_worker_since_.reset();
  for (auto& [id, worker] : workers_) {
    worker.pace().begin_generation();
  }
}

RemoteWorker* RemoteFleet::find(WorkerId id) {
  const auto found = workers_.find(id);
  return found == workers_.end() ? nullptr : &found->second;
}

std::vector<pid_t> RemoteFleet::ready_pids() const {
  std::vector<pid_t> pids;
  for (const auto& [id, worker] : workers_) {
    if (worker.ready()) {
      pids.push_back(worker.pid());
    }
  }
  return pids;
}

void RemoteFleet::hear(const wire::Hello& hello, const dds_sample_info_t& info) {
  const WorkerId id{hello.worker};
  const auto origin = dds_.origins.of(dds_.hellos.get(), info);
  if (info.valid_data && origin && !is_own(hello.worker, origin, "a Hello")) {
    return;
  }
  // A farewell counts even when the worker was gone before it was read.
  const bool farewell = info.valid_data && hello.leaving;
  if (!info.valid_data || (!farewell && info.instance_state != DDS_ALIVE_INSTANCE_STATE)) {
    lose(id, "is out of reach", InFlight::Farewell::died);
    return;
  }
  if (hello.protocol != wire::kProtocolVersion) {
    refuse(hello);
    return;
  }
  auto found = workers_.find(id);
  if (hello.leaving) {
    if (found != workers_.end()) {
      spdlog::debug("worker {} left", found->second.name());
      // A batch may have crossed its farewell: it goes to others at once.
      statistics_.requeued += flight_.lose_worker(id, InFlight::Farewell::left).batches;
      workers_.erase(found);
    }
    return;
  }
  if (found == workers_.end()) {
    meet(hello, origin);
    found = workers_.find(id);
    if (found == workers_.end()) {
      return;
    }
  }
  found->second.hear(hello, run_, Clock::now());
  // A worker that was out of reach has let go of the run, and DDS does not deliver again what it had before.
  stranger_ = stranger_ || hello.run_id != run_.run_id;
}

bool RemoteFleet::is_own(std::uint64_t worker, const std::optional<wire::Origin>& origin, const std::string& what) {
  const RemoteWorker* const known = find(WorkerId{worker});
  if (known == nullptr || known->origin() == origin) {
    return true;
  }
  if (origin) {
    reject(what + " in its name, from somebody else", worker);
  }
  return false;
}

void RemoteFleet::meet(const wire::Hello& hello, const std::optional<wire::Origin>& origin) {
  const WorkerId id{hello.worker};
  if (banned_.count(id) != 0) {
    cast_out(hello, coppice_wire_QUARANTINED);
    return;
  }
  if (workers_.size() >= kMaxWorkers || !origin) {  // gone already
    return;
  }
  auto worker = RemoteWorker::meet(dds_.participant, dds_.waiter, hello, *origin);
  if (!worker) {
    spdlog::error("cannot serve a worker: {}", worker.error().message);
    return;
  }
  spdlog::debug("worker {} is here", worker->name());
  flight_.add_worker(id, worker->lanes());
  workers_.emplace(id, std::move(*worker));
}

void RemoteFleet::refuse(const wire::Hello& hello) {
  cast_out(hello, coppice_wire_REFUSED_VERSION);
  if (refused_.size() < kMaxRemembered && refused_.insert(WorkerId{hello.worker}).second) {
    spdlog::warn(
        "refused the worker {} (pid {}, version {}): it speaks protocol {}, this coordinator (version {}) {}: "
        "install the same version of Coppice on both",
        wire::shown(hello.host), hello.pid, wire::shown(hello.version), hello.protocol, kVersion,
        wire::kProtocolVersion);
  }
}

void RemoteFleet::reject(const std::string& what, std::uint64_t source) {
  ++statistics_.rejected;
  if (rejected_from_.size() < kMaxRemembered && rejected_from_.insert(source).second) {
    spdlog::warn("dropped a sample of worker {:016x}: {} (further ones are only counted)", source, what);
  }
}

void RemoteFleet::ban(WorkerId id, const std::string& why) {
  if (banned_.size() < kMaxRemembered) {
    banned_.insert(id);
  }
  lose(id, why, InFlight::Farewell::left);
}

// A process of our own is known to be dead before its lease tells.
void RemoteFleet::lose_process(pid_t pid) {
  const auto found =
      std::find_if(workers_.begin(), workers_.end(), [&](const auto& entry) { return entry.second.pid() == pid; });
  if (found != workers_.end()) {
    lose(found->first, "died", InFlight::Farewell::died);
  }
}

void RemoteFleet::lose(WorkerId id, const std::string& why, InFlight::Farewell farewell) {
  const auto worker = workers_.find(id);
  if (worker == workers_.end()) {
    return;
  }
  const auto loss = flight_.lose_worker(id, farewell);
  ++statistics_.workers_lost;
  statistics_.requeued += loss.batches;
  spdlog::warn("worker {} {}; batches given to others: {}", worker->second.name(), why, loss.batches);
  workers_.erase(worker);
  poisonous_.insert(poisonous_.end(), loss.poisonous.begin(), loss.poisonous.end());
}

void RemoteFleet::tend(Clock::time_point now, std::uint64_t steps) {
  if (local_) {
    for (const LocalWorkers::Ended& ended : local_->tend()) {
      spdlog::warn("{}", ended.what);
      lose_process(ended.pid);
    }
  }
  lose_hanging(now, steps);
  show(now);
}

void RemoteFleet::show(Clock::time_point now) {
  if (now < next_show_) {
    return;
  }
  next_show_ = now + kShowInterval;
  std::erase_if(outcasts_, [now](const auto& entry) { return now - entry.second.heard > kOutcastMemory; });
  if (!dds_.fleet.matched()) {
    return;
  }
  std::vector<wire::WorkerStatus> workers;
  workers.reserve(workers_.size() + outcasts_.size());
  for (const auto& [id, worker] : workers_) {
    workers.push_back(worker.status(flight_.load(id), now));
  }
  for (const auto& [id, outcast] : outcasts_) {
    workers.push_back(outcast.status);
    const auto since = std::chrono::duration_cast<std::chrono::milliseconds>(now - outcast.heard);
    workers.back().seen_ms = static_cast<std::uint32_t>(since.count());
  }
  wire::Fleet fleet{};
  fleet.protocol = wire::kProtocolVersion;
  fleet.run_id = run_.run_id;
  wire::put_text(fleet.version, kVersion);
  wire::put_text(fleet.host, wire::host_name());
  fleet.pid = static_cast<std::uint32_t>(getpid());
  fleet.chain = wire::to_wire(run_.chain);
  fleet.workers._buffer = workers.data();
  fleet.workers._length = fleet.workers._maximum = static_cast<std::uint32_t>(workers.size());
  if (auto ok = dds_.fleet.write(fleet); !ok) {
    spdlog::debug("those who look on were not told: {}", ok.error().message);
  }
}

void RemoteFleet::cast_out(const wire::Hello& hello, coppice_wire_Doing why) {
  if (outcasts_.size() >= kMaxOutcasts && outcasts_.count(WorkerId{hello.worker}) == 0) {
    return;
  }
  Outcast& outcast = outcasts_[WorkerId{hello.worker}];
  outcast = {wire::status_of(hello), Clock::now()};
  outcast.status.doing = why;
}

// A worker that says Hello but stands still hangs, or never got what was sent. Its work goes to others; its next Hello
// makes it a worker like any other again. The limit doubles, so that individuals that take very long are not sent
// again and again.
void RemoteFleet::lose_hanging(Clock::time_point now, std::uint64_t steps) {
  std::vector<WorkerId> hanging;
  for (const auto& [id, worker] : workers_) {
    const auto usual = worker.pace().each(steps) * kHangFactor;
    if (flight_.load(id) > 0 && now - worker.progressed() > std::max<std::chrono::nanoseconds>(hang_limit_, usual)) {
      hanging.push_back(id);
    }
  }
  for (const WorkerId id : hanging) {
    lose(id, "makes no progress", InFlight::Farewell::left);
  }
  if (!hanging.empty()) {
    hang_limit_ = std::min<std::chrono::seconds>(hang_limit_ * 2, kLongestHangLimit);
  }
}

Result<void> RemoteFleet::wait_for_worker(Clock::time_point now, std::chrono::milliseconds limit,
                                          const std::string& interface) {
  const bool somebody =
      std::any_of(workers_.begin(), workers_.end(), [](const auto& entry) { return entry.second.ready(); });
  if (somebody) {
    without_worker_since_.reset();
    return {};
  }
  if (local_ && local_->running() == 0) {
    return failed("all worker processes ended; what was evaluated is kept");
  }
  if (!without_worker_since_) {
    without_worker_since_ = now;
    // Workers of our own need a moment: no word about it unless they take long.
    next_notice_ = local_ ? now + kNoticeInterval : now;
  }
  if (now - *without_worker_since_ > limit) {
    return failed(fmt::format("no worker within {} s; what was evaluated is kept",
                              std::chrono::duration_cast<std::chrono::seconds>(limit).count()));
  }
  if (now >= next_notice_) {
    next_notice_ = now + kNoticeInterval;
    spdlog::warn("no worker is there; waiting. Start one: coppice-worker --coordinator {} --domain {}",
                 interface == "lo" ? "127.0.0.1" : wire::host_name(), dds_.domain);
  }
  return {};
}

}  // namespace coppice
