#include "coordinator/dispatch/remote_evaluator.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "common/check.hpp"
#include "common/version.hpp"
#include "common/wire/codec.hpp"
#include "coordinator/dispatch/schedule.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds kTendInterval{100};  // child processes and the wait limit are looked at this often
constexpr std::chrono::milliseconds kSettlingInterval{5};  // new workers are looked at this often
constexpr std::size_t kMostPerTake = 1024;
constexpr std::ptrdiff_t kMostReason = 200;  // characters of a worker's reason that are logged
// A task's trees; far below the contract's bound, a UDP datagram's size.
constexpr std::size_t kTaskBytes = std::size_t{64} * 1024;

}  // namespace

RemoteEvaluator::RemoteEvaluator(std::shared_ptr<const Chain> chain, RemoteOptions options, const StopFlag& stop,
                                 RemoteEndpoints endpoints)
    : chain_(std::move(chain)),
      chain_bytes_(to_bytes(*chain_)),
      options_(std::move(options)),
      stop_(stop),
      run_{wire::random_identity(), hash_of(chain_bytes_)},
      dds_(std::move(endpoints)),
      wake_(stop.on_raise([this] { dds_.waiter.wake(); })),
      flight_(options_.limits),
      fleet_(dds_, run_, flight_, statistics_),
      meanings_(*chain_) {}

RemoteEvaluator::~RemoteEvaluator() {
  fleet_.dismiss();  // while DDS still acknowledges what the workers say last
}

Result<std::unique_ptr<RemoteEvaluator>> RemoteEvaluator::open(std::shared_ptr<const Chain> chain,
                                                               RemoteOptions options, const StopFlag& stop) {
  auto endpoints = RemoteEndpoints::open(options.domain, options.interface, options.network);
  if (!endpoints) {
    return tl::unexpected(endpoints.error());
  }
  std::unique_ptr<RemoteEvaluator> evaluator(
      new RemoteEvaluator(std::move(chain), std::move(options), stop, std::move(*endpoints)));
  if (auto ok = evaluator->announce(); !ok) {
    return tl::unexpected(ok.error());
  }
  if (evaluator->options_.local_workers > 0) {
    auto flags = evaluator->options_.worker_flags;
    flags.resize(evaluator->options_.local_workers);
    auto local = LocalWorkers::start(evaluator->options_.worker_program, flags, evaluator->domain());
    if (!local) {
      return tl::unexpected(local.error());
    }
    evaluator->fleet_.adopt(std::move(*local));
  }
  return evaluator;
}

Result<void> RemoteEvaluator::announce() {
  wire::Control control{};
  control.protocol = wire::kProtocolVersion;
  control.run_id = run_.run_id;
  wire::put_text(control.version, kVersion);
  wire::put_text(control.host, wire::host_name());
  control.pid = static_cast<std::uint32_t>(getpid());
  control.chain = wire::to_wire(run_.chain);
  control.chain_size = chain_bytes_.size();
  return dds_.control.write(control);
}

Result<void> RemoteEvaluator::check_objectives(const Job& job) {
  if (auto ok = check_job(job); !ok) {
    return ok;
  }
  if (auto ok = check_solvable(job, chain_->states()); !ok) {
    return ok;
  }
  if (job.objectives == checked_objectives_) {
    return {};
  }
  for (const Objective& objective : job.objectives) {
    if (const auto table = make_score_table(*chain_, objective); !table) {
      return tl::unexpected(table.error());
    }
  }
  checked_objectives_ = job.objectives;
  return {};
}

std::uint32_t RemoteEvaluator::most_per_task(std::span<const Tree> trees, const Job& job) const {
  std::size_t largest = 1;
  for (const Tree& tree : trees) {
    largest = std::max(largest, wire::encoded_size(tree));
  }
  const std::size_t answers =
      (wire::kMaxTaskPayload - sizeof(std::uint32_t)) / wire::encoded_tally_size(job.objectives.size());
  return static_cast<std::uint32_t>(
      std::max<std::size_t>(std::min({kTaskBytes / largest, answers, wire::kMaxTreesPerTask}), 1));
}

Result<std::vector<Tally>> RemoteEvaluator::evaluate(std::span<const Tree> trees, const Job& job) {
  if (auto ok = check_objectives(job); !ok) {
    return tl::unexpected(ok.error());
  }
  COPPICE_CHECK(trees.size() < (std::size_t{1} << 31U));
  // Trees that mean the same travel once.
  const std::vector<std::uint32_t> firsts = meanings_.firsts(trees);
  trees_.clear();
  slots_.clear();
  std::vector<std::uint32_t> sent_as(trees.size());
  for (std::uint32_t slot = 0; slot < trees.size(); ++slot) {
    if (firsts[slot] == slot) {
      sent_as[slot] = static_cast<std::uint32_t>(trees_.size());
      trees_.push_back(trees[slot]);
      slots_.push_back(slot);
    }
  }
  if (auto ok = evaluate_distinct(job); !ok) {
    return tl::unexpected(ok.error());
  }
  std::vector<Tally> tallies;
  tallies.reserve(trees.size());
  for (std::uint32_t slot = 0; slot < trees.size(); ++slot) {
    tallies.push_back(tallies_[sent_as[firsts[slot]]]);
    tallies.back().nodes = static_cast<std::uint32_t>(trees[slot].size());
  }
  statistics_.individuals += trees.size();
  statistics_.repeated += trees.size() - trees_.size();
  return tallies;
}

// Fills tallies_ for trees_.
Result<void> RemoteEvaluator::evaluate_distinct(const Job& job) {
  job_ = job;
  job_steps_ = tally_steps(job);
  most_per_task_ = most_per_task(trees_, job);
  last_settled_ = Clock::now();
  tallies_.assign(trees_.size(), Tally{});
  matching_changed_ = true;
  fleet_.begin();
  flight_.begin(static_cast<std::uint32_t>(trees_.size()));
  while (!flight_.done()) {
    if (auto ok = act(); !ok) {
      flight_.abandon();
      return tl::unexpected(ok.error());
    }
    if (!flight_.done()) {
      sleep();
    }
  }
  return {};
}

Result<void> RemoteEvaluator::await_workers(std::size_t count) {
  last_settled_ = Clock::now();
  fleet_.begin();
  while (ready_pids().size() < count) {
    if (auto ok = act(); !ok) {
      return ok;
    }
    sleep();
  }
  return {};
}

// Takes in what happened and does what follows from it.
Result<void> RemoteEvaluator::act() {
  if (stop_.raised()) {
    return tl::unexpected(Error{ErrorKind::interrupted, "interrupted"});
  }
  listen();
  const auto now = Clock::now();
  if (auto ok = tend(now); !ok) {
    return ok;
  }
  give_up(fleet_.take_poisonous());
  hand_out(now);
  return {};
}

void RemoteEvaluator::sleep() {
  const auto now = Clock::now();
  std::chrono::nanoseconds time = settling_ ? kSettlingInterval : kTendInterval;
  if (const auto due = flight_.next_due(); due && *due > now) {
    time = std::min<std::chrono::nanoseconds>(time, *due - now);
  }
  matching_changed_ = dds_.waiter.wait(time);
}

DispatchStatistics RemoteEvaluator::statistics() const {
  DispatchStatistics statistics = statistics_;
  statistics.workers_alive = ready_pids().size();
  return statistics;
}

bool RemoteEvaluator::is_ours(std::uint32_t protocol, std::uint64_t run_id, const coppice_wire_ChainId& chain) const {
  return protocol == wire::kProtocolVersion && run_id == run_.run_id && wire::from_wire(chain) == run_.chain;
}

void RemoteEvaluator::listen() {
  dds_.hellos.take(kMostPerTake,
                   [this](const wire::Hello& hello, const dds_sample_info_t& info) { fleet_.hear(hello, info); });
  dds_.requests.take(kMostPerTake, [this](const wire::ChainRequest& request, const dds_sample_info_t& info) {
    if (info.valid_data) {
      take(request);
    }
  });
  dds_.answers.take(kMostPerTake, [this](const wire::Answer& answer, const dds_sample_info_t& info) {
    if (info.valid_data) {
      take(answer);
    }
  });
  const auto now = Clock::now();
  settling_ = false;
  for (auto& [id, worker] : fleet_.workers()) {
    if (matching_changed_ || !worker.ready()) {
      worker.look(now);
    }
    settling_ = settling_ || worker.settling();
    worker.send_blocks(chain_bytes_, run_);
  }
}

void RemoteEvaluator::take(const wire::ChainRequest& request) {
  RemoteWorker* const worker = fleet_.find(WorkerId{request.worker});
  if (!is_ours(request.protocol, request.run_id, request.chain)) {
    fleet_.reject("a request for a chain that this run does not hold", request.worker);
  } else if (worker != nullptr) {
    worker->request_blocks(request.first, request.count);
  }  // else its Hello is still on the way: it asks again
}

void RemoteEvaluator::take(const wire::Answer& answer) {
  if (!is_ours(answer.protocol, answer.run_id, answer.chain)) {
    fleet_.reject("an answer of another run", answer.worker);
    return;
  }
  const BatchId batch{answer.batch};
  const WorkerId id{answer.worker};
  switch (answer.outcome) {
    case coppice_wire_EVALUATED:
      settle(answer);
      return;
    case coppice_wire_CHAIN_UNKNOWN:
      if (RemoteWorker* worker = fleet_.find(id); worker != nullptr) {
        worker->lacks_chain();  // until its next Hello says otherwise
      }
      break;
    case coppice_wire_GIVEN_BACK:
      break;
    case coppice_wire_REFUSED: {
      const auto text = wire::view(answer.payload);
      const std::string reason(text.begin(), text.begin() + std::min(std::ssize(text), kMostReason));
      fleet_.reject(fmt::format("it refused a batch: {}", wire::shown(reason.c_str())), answer.worker);
      fleet_.ban(id, "refused a batch");
      return;
    }
  }
  if (flight_.give_back(batch, id)) {
    ++statistics_.requeued;
  }
}

void RemoteEvaluator::settle(const wire::Answer& answer) {
  const BatchId id{answer.batch};
  const WorkerId from{answer.worker};
  statistics_.received_bytes += answer.payload._length;
  const auto out = flight_.find(id, from);
  if (!out || !out->current) {
    flight_.settle(id, from, Clock::now());  // of an earlier generation: frees the worker's credit
    ++statistics_.duplicates;
    return;
  }
  auto tallies = wire::decode_tallies(wire::view(answer.payload), out->batch.count, job_.objectives.size());
  if (!tallies || !fits(*tallies, out->batch)) {
    fleet_.reject(tallies ? "an answer to another batch" : tallies.error().message, answer.worker);
    fleet_.ban(from, "sent a damaged answer");
    return;
  }
  const auto now = Clock::now();
  const auto settlement = flight_.settle(id, from, now);
  if (settlement.fresh.empty()) {
    ++statistics_.duplicates;
    return;
  }
  last_settled_ = now;
  for (const std::uint32_t slot : settlement.fresh) {
    tallies_[slot] = std::move((*tallies)[slot - out->batch.first]);
  }
  if (RemoteWorker* worker = fleet_.find(from); worker != nullptr) {
    // No longer than it was away, whatever it says.
    const auto away = static_cast<std::uint64_t>(std::chrono::nanoseconds(last_settled_ - out->sent).count());
    worker->pace().add(std::chrono::nanoseconds(std::min(answer.elapsed_ns, away)), out->batch.count, job_steps_);
  }
}

bool RemoteEvaluator::fits(const std::vector<Tally>& tallies, const Batch& batch) const {
  for (std::uint32_t i = 0; i < batch.count; ++i) {
    const bool steps_fit = tallies[i].steps == job_steps_ || (job_.method != Method::rollouts && tallies[i].steps == 0);
    if (tallies[i].nodes != trees_[batch.first + i].size() || !steps_fit) {
      return false;
    }
  }
  return true;
}

Result<void> RemoteEvaluator::tend(Clock::time_point now) {
  if (now < next_tending_) {
    return {};
  }
  next_tending_ = now + kTendInterval;
  if (fleet_.take_stranger()) {
    if (auto ok = announce(); !ok) {
      spdlog::warn("{}", ok.error().message);
    }
  }
  fleet_.tend(now, job_steps_);
  if (now - last_settled_ > options_.wait_limit && !fleet_.workers().empty()) {
    return failed(fmt::format("no batch was answered for {} s; what was evaluated is kept",
                              std::chrono::duration_cast<std::chrono::seconds>(options_.wait_limit).count()));
  }
  return fleet_.wait_for_worker(now, options_.wait_limit, options_.interface);
}

void RemoteEvaluator::give_up(const std::vector<std::uint32_t>& slots) {
  for (const std::uint32_t slot : slots) {
    spdlog::error("slot {} is given the worst fitness: {} workers were lost while they held it", slots_[slot],
                  options_.limits.attempts);
    Tally& tally = tallies_[slot];
    tally.nodes = static_cast<std::uint32_t>(trees_[slot].size());
    tally.scores.assign(job_.objectives.size(), 0);
  }
}

void RemoteEvaluator::hand_out(Clock::time_point now) {
  std::vector<ReadyWorker> ready;
  ready.reserve(fleet_.workers().size());
  for (const auto& [id, worker] : fleet_.workers()) {
    if (worker.ready()) {
      ready.push_back({id, {worker.lanes(), worker.pace().each(job_steps_)}});
    }
  }
  for (const Assignment& assignment : next_assignments(flight_, ready, most_per_task_, now)) {
    RemoteWorker* const worker = fleet_.find(assignment.worker);
    COPPICE_CHECK(worker != nullptr);
    if (send(*worker, assignment.batch) && assignment.copy) {
      spdlog::debug("worker {} got a copy of a late batch", worker->name());
      ++statistics_.copies;
    }
  }
}

bool RemoteEvaluator::send(RemoteWorker& worker, const Batch& batch) {
  const auto payload = wire::encode_task(job_, std::span<const Tree>(trees_).subspan(batch.first, batch.count));
  if (auto ok = worker.send_task(batch, payload, run_, Clock::now()); !ok) {
    spdlog::warn("worker {}: {}", worker.name(), ok.error().message);
    flight_.give_back(batch.id, worker.id());
    return false;
  }
  ++statistics_.batches;
  statistics_.sent_bytes += payload.size();
  if (options_.batch_sent) {
    options_.batch_sent(worker.pid());
  }
  return true;
}

}  // namespace coppice
