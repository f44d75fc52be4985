#include "coordinator/dispatch/remote_worker.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace coppice {
namespace {

constexpr double kSmoothing = 0.3;  // weight of the newest measurement
// A worker's reader keeps kTaskDepth samples: it must never be sent more.
constexpr std::uint32_t kMaxLanes = wire::kTaskDepth / 2;

}  // namespace

RemoteWorker::RemoteWorker(const wire::Hello& hello, wire::Writer<wire::Task> tasks,
                           wire::Writer<wire::ChainBlock> blocks)
    : id_{hello.worker},
      pid_(static_cast<pid_t>(hello.pid)),
      lanes_(std::clamp(hello.threads, std::uint32_t{1}, kMaxLanes)),
      name_(fmt::format("{}, pid {}", wire::shown(hello.host), hello.pid)),
      tasks_(std::move(tasks)),
      blocks_(std::move(blocks)) {}

Result<RemoteWorker> RemoteWorker::meet(const wire::Participant& participant, wire::Waiter& waiter,
                                        const wire::Hello& hello) {
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
  return RemoteWorker(hello, std::move(*tasks), std::move(*blocks));
}

void RemoteWorker::hear(const wire::Hello& hello, const RunIdentity& run, InFlight::Time now) {
  if (hello.evaluated != evaluated_) {
    evaluated_ = hello.evaluated;
    progressed_ = now;
  }
  const std::span<const coppice_wire_ChainId> held(hello.chains._buffer, hello.chains._length);
  holds_chain_ = hello.run_id == run.run_id &&
                 std::any_of(held.begin(), held.end(),
                             [&](const coppice_wire_ChainId& id) { return wire::from_wire(id) == run.chain; });
}

void RemoteWorker::look() {
  tasks_matched_ = tasks_.matched();
  blocks_matched_ = blocks_.matched();
}

void RemoteWorker::request_blocks(std::uint32_t first, std::uint32_t count) {
  requested_ = Blocks{first, std::min(count, wire::kBlockWindow)};
}

std::size_t RemoteWorker::send_blocks(std::span<const std::uint8_t> chain_bytes, const RunIdentity& run) {
  if (!requested_ || !blocks_matched_) {
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

void RemoteWorker::measured(std::chrono::nanoseconds elapsed, std::uint32_t individuals, std::uint64_t steps) {
  const double now =
      static_cast<double>(elapsed.count()) / (static_cast<double>(individuals) * static_cast<double>(steps));
  ns_per_step_ = ns_per_step_ == 0.0 ? now : (1.0 - kSmoothing) * ns_per_step_ + kSmoothing * now;
}

std::chrono::nanoseconds RemoteWorker::cost_of(std::uint64_t steps) const {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(ns_per_step_ * static_cast<double>(steps)));
}

}  // namespace coppice
