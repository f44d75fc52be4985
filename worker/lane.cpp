#include "worker/lane.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <spdlog/spdlog.h>

namespace coppice {
namespace {

constexpr std::chrono::seconds kIdleWait{1};

void answer(const WorkerState& state, const wire::Task& task, coppice_wire_Outcome outcome,
            std::span<const std::uint8_t> payload, std::chrono::nanoseconds elapsed,
            wire::Writer<wire::Answer>& answers) {
  wire::Answer sample{};
  sample.protocol = state.protocol;
  sample.run_id = task.run_id;
  sample.chain = task.chain;
  sample.worker = state.worker;
  sample.batch = task.batch;
  sample.outcome = outcome;
  sample.elapsed_ns = static_cast<std::uint64_t>(elapsed.count());
  sample.payload = wire::lend(payload);
  if (auto ok = answers.write(sample); !ok) {
    // The coordinator offers the batch again when its deadline passes.
    spdlog::warn("an answer was not sent: {}", ok.error().message);
  }
}

std::vector<std::uint8_t> as_bytes(const std::string& text) { return {text.begin(), text.end()}; }

}  // namespace

void give_back(const WorkerState& state, const wire::Task& task, wire::Writer<wire::Answer>& answers) {
  answer(state, task, coppice_wire_GIVEN_BACK, {}, std::chrono::nanoseconds(0), answers);
}

Lane::Lane(WorkerState& state, wire::Waiter waiter, const wire::Reader<wire::Task>& tasks,
           wire::Writer<wire::Answer>& answers)
    : state_(state), waiter_(std::move(waiter)), tasks_(tasks), answers_(answers) {}

Result<std::unique_ptr<Lane>> Lane::start(WorkerState& state, const wire::Participant& participant,
                                          const wire::Reader<wire::Task>& tasks, wire::Writer<wire::Answer>& answers) {
  auto waiter = wire::Waiter::make(participant);
  if (!waiter) {
    return tl::unexpected(waiter.error());
  }
  if (auto ok = waiter->watch_reader(tasks.get()); !ok) {
    return tl::unexpected(ok.error());
  }
  std::unique_ptr<Lane> lane(new Lane(state, std::move(*waiter), tasks, answers));
  lane->thread_ = std::thread([raw = lane.get()] { raw->run(); });
  return lane;
}

Lane::~Lane() {
  if (thread_.joinable()) {
    thread_.join();
  }
}

void Lane::run() {
  while (!state_.leaving) {
    const std::size_t taken = tasks_.take(1, [this](const wire::Task& task, const dds_sample_info_t& info) {
      if (info.valid_data) {
        take_one(task);
      }
    });
    if (taken == 0) {
      waiter_.wait(kIdleWait);
    }
  }
}

void Lane::take_one(const wire::Task& task) {
  const std::uint64_t run_id = state_.run_id;
  if (task.protocol != state_.protocol || (run_id != 0 && task.run_id != run_id)) {
    return;  // of a coordinator that another has followed: nobody waits for it
  }
  const auto begin = std::chrono::steady_clock::now();
  const Outcome outcome = evaluate(task);
  answer(state_, task, outcome.kind, outcome.payload, std::chrono::steady_clock::now() - begin, answers_);
}

Lane::Outcome Lane::evaluate(const wire::Task& task) {
  const auto chain = state_.chains.find(wire::from_wire(task.chain));
  if (chain == nullptr) {
    return {coppice_wire_CHAIN_UNKNOWN, {}};
  }
  const auto decoded = wire::decode_task(wire::view(task.payload), chain->chain().vocabulary());
  if (!decoded) {
    spdlog::warn("refused a task: {}", decoded.error().message);
    return {coppice_wire_REFUSED, as_bytes(decoded.error().message)};
  }
  if (auto ok = prepare(chain, decoded->job); !ok) {
    return {coppice_wire_REFUSED, as_bytes(ok.error().message)};
  }
  std::vector<Tally> tallies;
  tallies.reserve(decoded->trees.size());
  const std::span<const Tree> trees = decoded->trees;
  while (tallies.size() < trees.size()) {
    if (state_.leaving) {
      return {coppice_wire_GIVEN_BACK, {}};
    }
    const std::size_t count = std::min<std::size_t>(evaluation_->trees_per_pass(), trees.size() - tallies.size());
    auto some = evaluation_->evaluate(trees.subspan(tallies.size(), count));
    std::move(some.begin(), some.end(), std::back_inserter(tallies));
    state_.evaluated.fetch_add(count, std::memory_order_relaxed);
  }
  auto payload = wire::encode_tallies(tallies);
  if (payload.size() > wire::kMaxTaskPayload) {
    return {coppice_wire_REFUSED, as_bytes("the answer would be larger than the contract allows")};
  }
  return {coppice_wire_EVALUATED, std::move(payload)};
}

Result<void> Lane::prepare(const std::shared_ptr<const PreparedChain>& chain, const Job& job) {
  if (job_ != nullptr && &job_->chain() == chain.get() && job_->job() == job) {
    return {};
  }
  auto prepared = PreparedJob::make(chain, job, job_);
  if (!prepared) {
    return tl::unexpected(prepared.error());
  }
  job_ = std::move(*prepared);
  evaluation_.emplace(job_);
  return {};
}

}  // namespace coppice
