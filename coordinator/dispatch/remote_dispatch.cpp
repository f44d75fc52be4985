#include "coordinator/dispatch/remote_dispatch.hpp"

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
// A tree's meaning is found in about 0.8 us; individuals whose walks take fewer steps are evaluated sooner than that
// saves. The worker that holds several of one meaning evaluates them once all the same.
constexpr std::uint64_t kStepsWorthSeeking = 5000;
constexpr std::chrono::microseconds kPaceWorthSeeking{20};

}  // namespace

RemoteDispatch::RemoteDispatch(std::shared_ptr<const Chain> chain, RemoteOptions options, const StopFlag& stop,
                               RemoteEndpoints endpoints)
    : chain_(std::move(chain)),
      chain_bytes_(to_bytes(*chain_)),
      options_(std::move(options)),
      stop_(stop),
      run_{wire::random_identity(), hash_of(chain_bytes_)},
      dds_(std::move(endpoints)),
      wake_(stop.on_raise([this] { dds_.waiter.wake(); })),
      flight_(options_.limits),
      requests_(flight_),
      fleet_(dds_, run_, flight_, statistics_),
      meanings_(*chain_),
      cross_check_(chain_, options_.cross_check, stop) {}

RemoteDispatch::~RemoteDispatch() {
  fleet_.dismiss();  // while DDS still acknowledges what the workers say last
}

Result<std::unique_ptr<RemoteDispatch>> RemoteDispatch::open(std::shared_ptr<const Chain> chain, RemoteOptions options,
                                                             const StopFlag& stop) {
  auto endpoints = RemoteEndpoints::open(options.domain, options.interface, options.network);
  if (!endpoints) {
    return tl::unexpected(endpoints.error());
  }
  std::unique_ptr<RemoteDispatch> evaluator(
      new RemoteDispatch(std::move(chain), std::move(options), stop, std::move(*endpoints)));
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

Result<void> RemoteDispatch::announce() {
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

Result<void> RemoteDispatch::check_objectives(const Job& job) {
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

bool RemoteDispatch::worth_seeking_repeats(const Job& job) const {
  if (job.method != Method::rollouts || tally_steps(job) >= kStepsWorthSeeking) {
    return true;
  }
  const auto& workers = fleet_.workers();
  return std::any_of(workers.begin(), workers.end(), [&](const auto& entry) {
    return entry.second.pace().each(tally_steps(job)) >= kPaceWorthSeeking;
  });
}

Result<RequestId> RemoteDispatch::submit(std::span<const Tree> trees, const Job& job) {
  if (auto ok = check_objectives(job); !ok) {
    return tl::unexpected(ok.error());
  }
  if (requests_.empty()) {
    last_settled_ = Clock::now();
    matching_changed_ = true;
  }
  if (begun_ >= requests_.size()) {
    fleet_.begin();
    begun_ = 0;
  }
  ++begun_;
  return requests_.open(trees, job, worth_seeking_repeats(job));
}

RemoteRequests::Finished RemoteDispatch::take(RequestId id) {
  RemoteRequests::Finished finished = requests_.take(id);
  statistics_.individuals += finished.tallies.size();
  statistics_.repeated += finished.repeated;
  return finished;
}

Result<void> RemoteDispatch::await_workers(std::size_t count) {
  last_settled_ = Clock::now();
  while (ready_pids().size() < count) {
    if (auto ok = act(); !ok) {
      return ok;
    }
    sleep();
  }
  return {};
}

Result<void> RemoteDispatch::act() {
  if (stop_.raised()) {
    return interrupted();
  }
  listen();
  if (taken_back_) {
    cross_check_.begin_again();
    if (options_.taken_back) {
      options_.taken_back();
    }
    return tl::unexpected(*std::exchange(taken_back_, std::nullopt));
  }
  if (stop_.raised()) {  // perhaps while an answer was checked: what was settled since may be a lie
    return interrupted();
  }
  const auto now = Clock::now();
  if (auto ok = tend(now); !ok) {
    return ok;
  }
  give_up(fleet_.take_poisonous());
  requests_.see_portions(meanings_);
  hand_out(now);
  return {};
}

void RemoteDispatch::sleep() {
  if (!requests_.all_seen()) {
    return;
  }
  const auto now = Clock::now();
  std::chrono::nanoseconds time = settling_ ? kSettlingInterval : kTendInterval;
  if (const auto due = flight_.next_due(); due && *due > now) {
    time = std::min<std::chrono::nanoseconds>(time, *due - now);
  }
  matching_changed_ = dds_.waiter.wait(time);
}

DispatchStatistics RemoteDispatch::statistics() const {
  DispatchStatistics statistics = statistics_;
  statistics.workers_alive = ready_pids().size();
  return statistics;
}

bool RemoteDispatch::is_ours(std::uint32_t protocol, std::uint64_t run_id, const coppice_wire_ChainId& chain) const {
  return protocol == wire::kProtocolVersion && run_id == run_.run_id && wire::from_wire(chain) == run_.chain;
}

void RemoteDispatch::listen() {
  dds_.hellos.take(kMostPerTake,
                   [this](const wire::Hello& hello, const dds_sample_info_t& info) { fleet_.hear(hello, info); });
  dds_.requests.take(kMostPerTake, [this](const wire::ChainRequest& request, const dds_sample_info_t& info) {
    if (info.valid_data && fleet_.is_own(request.worker, dds_.origins.of(dds_.requests.get(), info), "a request")) {
      take(request);
    }
  });
  dds_.answers.take(kMostPerTake, [this](const wire::Answer& answer, const dds_sample_info_t& info) {
    if (info.valid_data && fleet_.is_own(answer.worker, dds_.origins.of(dds_.answers.get(), info), "an answer")) {
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

void RemoteDispatch::take(const wire::ChainRequest& request) {
  RemoteWorker* const worker = fleet_.find(WorkerId{request.worker});
  if (!is_ours(request.protocol, request.run_id, request.chain)) {
    fleet_.reject("a request for a chain that this run does not hold", request.worker);
  } else if (worker != nullptr) {
    worker->request_blocks(request.first, request.count);
  }  // else its Hello is still on the way: it asks again
}

void RemoteDispatch::take(const wire::Answer& answer) {
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

void RemoteDispatch::settle(const wire::Answer& answer) {
  const BatchId id{answer.batch};
  const WorkerId from{answer.worker};
  if (fleet_.is_banned(from)) {
    ++statistics_.rejected;
    return;
  }
  statistics_.received_bytes += answer.payload._length;
  const auto out = flight_.find(id, from);
  if (!out || !out->current) {
    flight_.settle(id, from, Clock::now());  // of an earlier generation: frees the worker's credit
    ++statistics_.duplicates;
    return;
  }
  const auto [request, first] = requests_.place_of(out->batch);
  auto tallies = wire::decode_tallies(wire::view(answer.payload), out->batch.count, request.job().objectives.size());
  if (!tallies || !request.fits(*tallies, first)) {
    fleet_.reject(tallies ? "an answer to another batch" : tallies.error().message, answer.worker);
    fleet_.ban(from, "sent a damaged answer");
    return;
  }
  const bool honest = cross_check_.agrees(from, *tallies, request, first);
  statistics_.cross_checked += cross_check_.sampled();
  if (!honest) {
    quarantine(from);
    return;
  }
  const auto now = Clock::now();
  const auto settlement = flight_.settle(id, from, now);
  if (settlement.fresh.empty()) {
    ++statistics_.duplicates;
    return;
  }
  last_settled_ = now;
  request.add_repeated(std::min(answer.repeated, out->batch.count));
  std::uint32_t unchecked = 0;
  for (const std::uint32_t slot : settlement.fresh) {
    const std::uint32_t individual = slot - out->batch.first;
    const bool checked = cross_check_.was_sampled(individual);
    request.settle(first + individual, std::move((*tallies)[individual]), checked ? WorkerId{} : from);
    unchecked += checked ? 0 : 1;
  }
  cross_check_.took_unchecked(from, unchecked);
  if (RemoteWorker* worker = fleet_.find(from); worker != nullptr) {
    // No longer than it was away, whatever it says.
    const auto away = static_cast<std::uint64_t>(std::chrono::nanoseconds(last_settled_ - out->sent).count());
    worker->pace().add(std::chrono::nanoseconds(std::min(answer.elapsed_ns, away)), out->batch.count, request.steps());
  }
}

// A worker answered wrongly: nothing that it said counts any more, unless it was checked. In the requests that are open
// it is evaluated again here, earlier ones are taken back.
void RemoteDispatch::quarantine(WorkerId from) {
  std::size_t again = 0;
  requests_.for_each([&](RemoteRequest& request) { again += cross_check_.redo(request, from); });
  const std::uint64_t earlier =
      cross_check_.unchecked(from) - std::min<std::uint64_t>(again, cross_check_.unchecked(from));
  const RemoteWorker* const worker = fleet_.find(from);
  const std::string said =
      fmt::format("worker {} answered wrongly and is quarantined",
                  worker != nullptr ? worker->name() : fmt::format("{:016x}", static_cast<std::uint64_t>(from)));
  spdlog::error(
      "{}: {} of its individuals in this generation were evaluated again; {} in earlier ones had counted as it "
      "said",
      said, again, earlier);
  if (earlier > 0) {
    taken_back_ =
        Error{ErrorKind::failed, fmt::format("{}, after {} of its individuals had counted as it said", said, earlier)};
  }
  ++statistics_.quarantined;
  fleet_.ban(from, "is quarantined");
}

Result<void> RemoteDispatch::tend(Clock::time_point now) {
  if (now < next_tending_) {
    return {};
  }
  next_tending_ = now + kTendInterval;
  if (fleet_.take_stranger()) {
    if (auto ok = announce(); !ok) {
      spdlog::warn("{}", ok.error().message);
    }
  }
  fleet_.tend(now, requests_.most_steps());
  if (!requests_.empty() && now - last_settled_ > options_.wait_limit && !fleet_.workers().empty()) {
    return failed(fmt::format("no batch was answered for {} s; what was evaluated is kept",
                              std::chrono::duration_cast<std::chrono::seconds>(options_.wait_limit).count()));
  }
  return fleet_.wait_for_worker(now, options_.wait_limit, options_.interface);
}

void RemoteDispatch::give_up(const std::vector<Slot>& slots) {
  for (const Slot& slot : slots) {
    const auto [request, place] = requests_.place_of(slot);
    const std::uint32_t given_up = request.give_up(place);
    spdlog::error("slot {} is given the worst fitness: {} workers were lost while they held it", given_up,
                  options_.limits.attempts);
  }
}

void RemoteDispatch::hand_out(Clock::time_point now) {
  if (flight_.done()) {
    return;
  }
  // Batches of requests with other jobs may be sized a little wrong by this, which costs time only.
  const std::uint64_t steps = requests_.steps_at_front();
  const Horizon horizon = requests_.horizon(static_cast<std::uint32_t>(wire::kMaxTreesPerTask));
  std::vector<ReadyWorker> ready;
  ready.reserve(fleet_.workers().size());
  for (const auto& [id, worker] : fleet_.workers()) {
    if (worker.ready()) {
      ready.push_back({id, {worker.lanes(), worker.pace().each(steps)}});
    }
  }
  for (const Assignment& assignment : next_assignments(flight_, ready, horizon, now)) {
    RemoteWorker* const worker = fleet_.find(assignment.worker);
    COPPICE_CHECK(worker != nullptr);
    if (send(*worker, assignment.batch) && assignment.copy) {
      spdlog::debug("worker {} got a copy of a late batch", worker->name());
      ++statistics_.copies;
    }
  }
}

bool RemoteDispatch::send(RemoteWorker& worker, const Batch& batch) {
  const auto [request, first] = requests_.place_of(batch);
  const auto payload = request.task(first, batch.count);
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
