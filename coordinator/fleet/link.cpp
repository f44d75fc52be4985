#include "coordinator/fleet/link.hpp"

#include <algorithm>
#include <utility>

#include "coordinator/dispatch/roster.hpp"

namespace coppice {
namespace {

// A reader takes in nothing before its writer's first heartbeat, which it asks for 10 ms after the match
// (PreEmptiveAckDelay); what is written before comes with the next one, 100 ms later. Shorter heartbeats would mend it
// too, but then 200 workers take up to half a minute to be discovered.
constexpr std::chrono::milliseconds kSettlingTime{15};
// A worker's reader keeps kTaskDepth samples: it must never be sent more.
static_assert(Roster::kMaxLanes <= wire::kTaskDepth / 2);

coppice_wire_Work to_wire(WorkKind work) {
  switch (work) {
    case WorkKind::evolve:
      return coppice_wire_EVOLVE;
    case WorkKind::evaluate:
      break;
  }
  return coppice_wire_EVALUATE;
}

}  // namespace

Result<Link> Link::open(const wire::Participant& participant, wire::Waiter& waiter, WorkerId worker) {
  const std::string partition = wire::partition_of(static_cast<std::uint64_t>(worker));
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
  return Link(std::move(*tasks), std::move(*blocks));
}

void Link::Match::look(bool matched, Time now) {
  if (!matched) {
    since.reset();
  } else if (!since) {
    since = now;
  }
  settled = since && now - *since >= kSettlingTime;
}

bool Link::look(Time now) {
  const bool before = settled();
  task_match_.look(tasks_.matched(), now);
  block_match_.look(blocks_.matched(), now);
  return settled() != before;
}

void Link::request_blocks(std::uint32_t first, std::uint32_t count) {
  requested_ = Blocks{first, std::min(count, wire::kBlockWindow)};
}

void Link::send_blocks(std::span<const std::uint8_t> chain_bytes, const RunIdentity& run) {
  if (!requested_ || !block_match_.settled) {
    return;
  }
  const Blocks blocks = *std::exchange(requested_, std::nullopt);
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
    static_cast<void>(blocks_.write(block));  // what does not come is asked for again
  }
}

Result<void> Link::send_task(BatchId batch, WorkKind work, std::span<const std::uint8_t> payload,
                             const RunIdentity& run) {
  wire::Task task{};
  task.protocol = wire::kProtocolVersion;
  task.run_id = run.run_id;
  task.chain = wire::to_wire(run.chain);
  task.batch = static_cast<std::uint64_t>(batch);
  task.work = to_wire(work);
  task.payload = wire::lend(payload);
  return tasks_.write(task);
}

}  // namespace coppice
