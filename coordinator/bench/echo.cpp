#include "coordinator/bench/echo.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <string>

#include "common/chain/bytes.hpp"
#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMostEchoesPerTake = 1024;
constexpr std::chrono::milliseconds kMostSleep{100};

}  // namespace

Echo::Echo(Endpoints endpoints, LocalWorkers local, const StopFlag& stop)
    : dds_(std::move(endpoints)),
      stop_(stop),
      wake_(stop.on_raise([this] { dds_.waiter.wake(); })),
      run_id_(wire::random_identity()),
      local_(std::move(local)) {}

Result<std::unique_ptr<Echo>> Echo::open(const std::filesystem::path& worker_program, std::size_t workers,
                                         const StopFlag& stop, const wire::Network& network,
                                         std::vector<LocalWorkers::Flags> flags) {
  auto endpoints = Endpoints::open(std::nullopt, "lo", network);
  if (!endpoints) {
    return tl::unexpected(endpoints.error());
  }
  flags.resize(workers);
  for (LocalWorkers::Flags& one : flags) {
    one.emplace_back("--echo");
  }
  auto local = LocalWorkers::start(worker_program, flags, endpoints->domain);
  if (!local) {
    return tl::unexpected(local.error());
  }
  std::unique_ptr<Echo> echo(new Echo(std::move(*endpoints), std::move(*local), stop));
  if (auto ok = echo->await_peers(workers); !ok) {
    return tl::unexpected(ok.error());
  }
  return echo;
}

Result<void> Echo::sleep(Clock::time_point limit) {
  if (stop_.raised()) {
    return interrupted();
  }
  if (Clock::now() > limit) {
    return failed(fmt::format("the bare transport stood still for {} s", kPatience.count()));
  }
  dds_.waiter.wait(kMostSleep);
  return {};
}

Result<void> Echo::meet(const wire::Hello& hello) {
  if (std::any_of(peers_.begin(), peers_.end(), [&](const Peer& peer) { return peer.worker == hello.worker; })) {
    return {};
  }
  auto tasks = wire::Writer<wire::Task>::make(dds_.participant, wire::partition_of(hello.worker));
  if (!tasks) {
    return tl::unexpected(tasks.error());
  }
  peers_.push_back({hello.worker, std::move(*tasks), 0});
  return dds_.waiter.watch_matching(peers_.back().tasks.get());
}

Result<void> Echo::await_peers(std::size_t count) {
  const auto limit = Clock::now() + kPatience;
  const auto all_there = [&] {
    return peers_.size() == count &&
           std::all_of(peers_.begin(), peers_.end(), [](const Peer& peer) { return peer.tasks.matched(); });
  };
  while (!all_there()) {
    Result<void> met;
    dds_.hellos.take(kMostEchoesPerTake, [&](const wire::Hello& hello, const dds_sample_info_t& info) {
      if (info.valid_data && met) {
        met = meet(hello);
      }
    });
    if (met) {
      met = sleep(limit);
    }
    if (!met) {
      return met;
    }
  }
  return {};
}

Echo::Traffic Echo::chain_traffic(std::uint64_t bytes) {
  constexpr std::size_t kAnswerBytes = 16;
  return {.batches = (bytes + wire::kBlockBytes - 1) / wire::kBlockBytes,
          .task_bytes = std::min<std::size_t>(wire::kBlockBytes, bytes),
          .answer_bytes = kAnswerBytes,
          .ahead = wire::kBlockWindow};
}

Result<void> Echo::exchange(const Traffic& traffic) {
  COPPICE_CHECK(traffic.task_bytes <= wire::kMaxTaskPayload && traffic.answer_bytes <= wire::kMaxTaskPayload &&
                traffic.ahead <= wire::kTaskDepth);
  ByteWriter asked;
  asked.put(static_cast<std::uint32_t>(traffic.answer_bytes));
  std::vector<std::uint8_t> payload = asked.take();
  payload.resize(std::max(payload.size(), traffic.task_bytes));
  const auto limit = Clock::now() + kPatience;
  std::size_t sent = 0;
  std::size_t answered = 0;
  while (answered < traffic.batches) {
    // One for everybody before a second one for anybody.
    for (std::size_t credit = 1; credit <= traffic.ahead; ++credit) {
      for (Peer& peer : peers_) {
        if (sent == traffic.batches || peer.out >= credit) {
          continue;
        }
        wire::Task task{};
        task.protocol = wire::kProtocolVersion;
        task.run_id = run_id_;
        task.batch = sent;
        task.payload = wire::lend(payload);
        if (auto ok = peer.tasks.write(task); !ok) {
          return ok;
        }
        ++peer.out;
        ++sent;
      }
    }
    const std::size_t before = answered;
    dds_.answers.take(kMostEchoesPerTake, [&](const wire::Answer& answer, const dds_sample_info_t& info) {
      const auto peer = std::find_if(peers_.begin(), peers_.end(),
                                     [&](const Peer& candidate) { return candidate.worker == answer.worker; });
      if (info.valid_data && answer.run_id == run_id_ && peer != peers_.end()) {
        --peer->out;
        ++answered;
      }
    });
    if (answered == before) {
      if (auto ok = sleep(limit); !ok) {
        return ok;
      }
    }
  }
  return {};
}

}  // namespace coppice
