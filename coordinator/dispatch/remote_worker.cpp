#include "coordinator/dispatch/remote_worker.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace coppice {
namespace {

// A reader takes in nothing before its writer's first heartbeat, which it asks for 10 ms after the match
// (PreEmptiveAckDelay); what is written before comes with the next one, 100 ms later. Shorter heartbeats would mend it
// too, but then 200 workers take up to half a minute to be discovered.
constexpr std::chrono::milliseconds kSettlingTime{15};
// A worker's reader keeps kTaskDepth samples: it must never be sent more.
constexpr std::uint32_t kMaxLanes = wire::kTaskDepth / 2;
constexpr std::chrono::seconds kPaceWindow{1};

}  // namespace

RemoteWorker::RemoteWorker(const wire::Hello& hello, const wire::Origin& origin, wire::Writer<wire::Task> tasks,
                           wire::Writer<wire::ChainBlock> blocks)
    : id_{hello.worker},
      origin_(origin),
      pid_(static_cast<pid_t>(hello.pid)),
      status_(wire::status_of(hello)),
      lanes_(std::clamp(hello.threads, std::uint32_t{1}, kMaxLanes)),
      name_(fmt::format("{}, pid {}", wire::shown(hello.host), hello.pid)),
      tasks_(std::move(tasks)),
      blocks_(std::move(blocks)) {}

Result<RemoteWorker> RemoteWorker::meet(const wire::Participant& participant, wire::Waiter& waiter,
                                        const wire::Hello& hello, const wire::Origin& origin) {
  const std::string partition = wire::partition_of(hello.worker);
  auto tasks = wire::Writer<wire::Task>::make(participant, partition);
  if (!tasks) {
    return tl::unexpected(tasks.error());
  }
  auto blocks = wire::Writer<wire::ChainBlock>::make(participant, partition);
  if (!blocks) {
    return tl::unexpected(blocks.error());
  }
  for (const dds_entity_t writer : {tasks->get(), blocks->get()}) {
    if (auto ok = waiter.watch_matching(writer); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  return RemoteWorker(hello, origin, std::move(*tasks), std::move(*blocks));
}

void RemoteWorker::hear(const wire::Hello& hello, const RunIdentity& run, InFlight::Time now) {
  if (hello.evaluated != evaluated_) {
    evaluated_ = hello.evaluated;
    progressed_ = now;
  }
  heard_ = now;
  status_.evaluated = hello.evaluated;
  if (const auto window = now - lately_.since; window >= kPaceWindow) {
    const auto seconds = std::chrono::duration<double>(window).count();
    const bool counts = lately_.since != InFlight::Time{} && hello.evaluated >= lately_.evaluated;
    lately_ = {
        now, hello.evaluated,
        counts ? static_cast<std::uint64_t>(static_cast<double>(hello.evaluated - lately_.evaluated) / seconds) : 0};
  }
  const std::span<const coppice_wire_ChainId> held(hello.chains._buffer, hello.chains._length);
  holds_chain_ = hello.run_id == run.run_id &&
                 std::any_of(held.begin(), held.end(),
                             [&](const coppice_wire_ChainId& id) { return wire::from_wire(id) == run.chain; });
}

wire::WorkerStatus RemoteWorker::status(std::size_t batches, InFlight::Time now) const {
  wire::WorkerStatus status = status_;
  status.doing = !holds_chain_ ? coppice_wire_FETCHING : batches > 0 ? coppice_wire_EVALUATING : coppice_wire_READY;
  status.batches = static_cast<std::uint32_t>(batches);
  status.each_second = lately_.each_second;
  status.seen_ms =
      static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::milliseconds>(now - heard_).count());
  return status;
}

void RemoteWorker::Match::look(bool matched, InFlight::Time now) {
  if (!matched) {
    since.reset();
  } else if (!since) {
    since = now;
  }
  settled = since && now - *since >= kSettlingTime;
}

void RemoteWorker::look(InFlight::Time now) {
  task_match_.look(tasks_.matched(), now);
  block_match_.look(blocks_.matched(), now);
}

void RemoteWorker::request_blocks(std::uint32_t first, std::uint32_t count) {
  requested_ = Blocks{first, std::min(count, wire::kBlockWindow)};
}

std::size_t RemoteWorker::send_blocks(std::span<const std::uint8_t> chain_bytes, const RunIdentity& run) {
  if (!requested_ || !block_match_.settled) {
    return 0;
  }
  const Blocks blocks = *std::exchange(requested_, std::nullopt);
  std::size_t sent = 0;
  for (std::uint64_t index = blocks.first; index < std::uint64_t{blocks.first} + blocks.count; ++index) {
    const std::uint64_t begin = index * wire::kBlockBytes;
    if (begin >= chain_bytes.size()) {
      break;
    }
    wire::ChainBlock block{};
    block.protocol = wire::kProtocolVersion;
    block.run_id = run.run_id;
    block.chain = wire::to_wire(run.chain);
    block.index = static_cast<std::uint32_t>(index);
    block.payload = wire::lend(chain_bytes.subspan(begin, std::min(wire::kBlockBytes, chain_bytes.size() - begin)));
    if (blocks_.write(block)) {  // else the worker asks again
      ++sent;
    }
  }
  return sent;
}

Result<void> RemoteWorker::send_task(const Batch& batch, std::span<const std::uint8_t> payload, const RunIdentity& run,
                                     InFlight::Time now) {
  progressed_ = now;
  wire::Task task{};
  task.protocol = wire::kProtocolVersion;
  task.run_id = run.run_id;
  task.chain = wire::to_wire(run.chain);
  task.batch = static_cast<std::uint64_t>(batch.id);
  task.payload = wire::lend(payload);
  return tasks_.write(task);
}

}  // namespace coppice
