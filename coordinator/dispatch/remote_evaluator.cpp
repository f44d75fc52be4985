#include "coordinator/dispatch/remote_evaluator.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <random>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "common/check.hpp"
#include "common/version.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/configuration.hpp"
#include "coordinator/dispatch/batch_size.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr auto kTendInterval = 100ms;      // child processes and the wait limit are looked at this often
constexpr auto kNoticeInterval = 10s;      // "waiting for a worker" is repeated this often
constexpr auto kShortestPatience = 250ms;  // a batch is not overdue before
constexpr auto kLongestPatience = 60s;
constexpr auto kPatienceUnmeasured = 2s;
constexpr auto kHangLimit = 5s;  // no progress with work at hand for this long, doubled each time
constexpr auto kLongestHangLimit = 3600s;
constexpr int kPatienceFactor = 4;  // times the measured cost of all that the worker has before it
constexpr std::size_t kMostPerTake = 1024;
constexpr std::size_t kMaxWorkers = 1024;
constexpr std::ptrdiff_t kMostReason = 200;   // characters of a worker's reason that are logged
constexpr std::size_t kMaxRemembered = 4096;  // sources that were logged
constexpr std::size_t kTaskBytes =
    64 * 1024;                                // a task's trees; far below the contract's bound, one UDP datagram's size
constexpr std::uint32_t kLocalDomains = 200;  // domains 1..200 are for local runs, 0 is the default for others

template <typename T>
Result<void> keep_error(const Result<T>& result, Result<void> so_far) {
  return so_far && !result ? Result<void>(tl::unexpected(result.error())) : so_far;
}

struct Joined {
  std::uint32_t domain;
  wire::Participant participant;
};

Result<Joined> join(const RemoteOptions& options) {
  if (auto ok = wire::check_interface(options.interface); !ok) {
    return in_context("--interface", ok.error());
  }
  const std::string configuration = wire::coordinator_configuration(options.interface);
  if (options.domain) {
    auto participant = wire::Participant::join(*options.domain, configuration);
    if (!participant) {
      return failed(
          fmt::format("domain {} cannot be used (UDP port {}; is another coordinator on this machine? choose "
                      "another with --domain): {}",
                      *options.domain, wire::coordinator_port(*options.domain), participant.error().message));
    }
    return Joined{*options.domain, std::move(*participant)};
  }
  // Starting at a place that depends on the process, so that two runs seldom try the same.
  std::string last;
  for (std::uint32_t i = 0; i < kLocalDomains; ++i) {
    const std::uint32_t domain = 1 + (static_cast<std::uint32_t>(getpid()) + i) % kLocalDomains;
    auto participant = wire::Participant::join(domain, configuration);
    if (participant) {
      return Joined{domain, std::move(*participant)};
    }
    last = participant.error().message;
  }
  return failed(fmt::format("no DDS domain of 1 to {} is free on this machine: {}", kLocalDomains, last));
}

}  // namespace

RemoteEvaluator::RemoteEvaluator(std::shared_ptr<const Chain> chain, RemoteOptions options, const StopFlag& stop,
                                 std::uint32_t domain, Endpoints endpoints)
    : chain_(std::move(chain)),
      chain_bytes_(to_bytes(*chain_)),
      options_(std::move(options)),
      stop_(stop),
      domain_(domain),
      dds_(std::move(endpoints)),
      wake_(stop.on_raise([this] { dds_.waiter.wake(); })),
      flight_(options_.limits),
      hang_limit_(kHangLimit) {
  std::random_device device;
  run_.run_id = (static_cast<std::uint64_t>(device()) << 32U) | device() | 1U;
  run_.chain = hash_of(chain_bytes_);
}

RemoteEvaluator::~RemoteEvaluator() {
  local_.reset();  // while DDS still acknowledges what the workers say last
}

Result<std::unique_ptr<RemoteEvaluator>> RemoteEvaluator::open(std::shared_ptr<const Chain> chain,
                                                               RemoteOptions options, const StopFlag& stop) {
  auto joined = join(options);
  if (!joined) {
    return tl::unexpected(joined.error());
  }
  const wire::Participant& participant = joined->participant;
  auto waiter = wire::Waiter::make(participant);
  auto hellos = wire::Reader<wire::Hello>::make(participant);
  auto answers = wire::Reader<wire::Answer>::make(participant);
  auto requests = wire::Reader<wire::ChainRequest>::make(participant);
  auto control = wire::Writer<wire::Control>::make(participant);
  Result<void> ok = keep_error(
      control, keep_error(requests, keep_error(answers, keep_error(hellos, keep_error(waiter, Result<void>{})))));
  if (ok) {
    for (const dds_entity_t reader : {hellos->get(), answers->get(), requests->get()}) {
      ok = keep_error(waiter->watch_reader(reader), ok);
    }
  }
  if (!ok) {
    return tl::unexpected(ok.error());
  }
  const std::uint32_t domain = joined->domain;
  std::unique_ptr<RemoteEvaluator> evaluator(
      new RemoteEvaluator(std::move(chain), std::move(options), stop, domain,
                          Endpoints{std::move(joined->participant), std::move(*waiter), std::move(*hellos),
                                    std::move(*answers), std::move(*requests), std::move(*control)}));
  if (ok = evaluator->announce(); !ok) {
    return tl::unexpected(ok.error());
  }
  if (evaluator->options_.local_workers > 0) {
    auto local = LocalWorkers::start(evaluator->options_.worker_program, evaluator->options_.local_workers, domain);
    if (!local) {
      return tl::unexpected(local.error());
    }
    evaluator->local_.emplace(std::move(*local));
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

Result<std::vector<Tally>> RemoteEvaluator::evaluate(std::span<const Tree> trees, const Job& job) {
  if (auto ok = check_objectives(job); !ok) {
    return tl::unexpected(ok.error());
  }
  COPPICE_CHECK(trees.size() < (std::size_t{1} << 31U));
  trees_ = trees;
  job_ = job;
  job_steps_ = tally_steps(job);
  std::size_t largest = 1;
  for (const Tree& tree : trees) {
    largest = std::max(largest, wire::encoded_size(tree));
  }
  const std::size_t answers =
      (wire::kMaxTaskPayload - sizeof(std::uint32_t)) / wire::encoded_tally_size(job.objectives.size());
  most_per_task_ = static_cast<std::uint32_t>(
      std::max<std::size_t>(std::min({kTaskBytes / largest, answers, wire::kMaxTreesPerTask}), 1));
  without_worker_since_.reset();
  last_settled_ = Clock::now();
  tallies_.assign(trees.size(), Tally{});
  flight_.begin(static_cast<std::uint32_t>(trees.size()));
  while (!flight_.done()) {
    if (stop_.raised()) {
      flight_.abandon();
      return tl::unexpected(Error{ErrorKind::interrupted, "interrupted"});
    }
    listen();
    const auto now = Clock::now();
    if (auto ok = tend(now); !ok) {
      flight_.abandon();
      return tl::unexpected(ok.error());
    }
    hand_out(now);
    if (!flight_.done()) {
      dds_.waiter.wait(time_to_sleep(now));
    }
  }
  hang_limit_ = kHangLimit;
  statistics_.individuals += trees.size();
  return std::move(tallies_);
}

DispatchStatistics RemoteEvaluator::statistics() const {
  DispatchStatistics statistics = statistics_;
  statistics.workers_alive = ready_pids().size();
  return statistics;
}

std::vector<pid_t> RemoteEvaluator::ready_pids() const {
  std::vector<pid_t> pids;
  for (const auto& [id, worker] : workers_) {
    if (worker.ready()) {
      pids.push_back(worker.pid());
    }
  }
  return pids;
}

bool RemoteEvaluator::is_ours(std::uint32_t protocol, std::uint64_t run_id, const coppice_wire_ChainId& chain) const {
  return protocol == wire::kProtocolVersion && run_id == run_.run_id && wire::from_wire(chain) == run_.chain;
}

void RemoteEvaluator::reject(const std::string& what, std::uint64_t source) {
  ++statistics_.rejected;
  if (rejected_from_.size() < kMaxRemembered && rejected_from_.insert(source).second) {
    spdlog::warn("dropped a sample of worker {:016x}: {} (further ones are only counted)", source, what);
  }
}

void RemoteEvaluator::listen() {
  dds_.hellos.take(kMostPerTake,
                   [this](const wire::Hello& hello, const dds_sample_info_t& info) { hear(hello, info); });
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
  for (auto& [id, worker] : workers_) {
    worker.look();
    worker.send_blocks(chain_bytes_, run_);
  }
}

void RemoteEvaluator::hear(const wire::Hello& hello, const dds_sample_info_t& info) {
  const WorkerId id{hello.worker};
  if (!info.valid_data || info.instance_state != DDS_ALIVE_INSTANCE_STATE) {
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
    if (banned_.count(id) != 0 || workers_.size() >= kMaxWorkers) {
      return;
    }
    auto worker = RemoteWorker::meet(dds_.participant, dds_.waiter, hello);
    if (!worker) {
      spdlog::error("cannot serve a worker: {}", worker.error().message);
      return;
    }
    spdlog::debug("worker {} is here", worker->name());
    found = workers_.emplace(id, std::move(*worker)).first;
    flight_.add_worker(id, found->second.lanes());
  }
  found->second.hear(hello, run_, Clock::now());
  // A worker that was out of reach has let go of the run, and DDS does not deliver again what it had before.
  announce_again_ = announce_again_ || hello.run_id != run_.run_id;
}

void RemoteEvaluator::refuse(const wire::Hello& hello) {
  if (refused_.size() < kMaxRemembered && refused_.insert(WorkerId{hello.worker}).second) {
    spdlog::warn(
        "refused the worker {} (pid {}, version {}): it speaks protocol {}, this coordinator (version {}) {}: "
        "install the same version of Coppice on both",
        wire::shown(hello.host), hello.pid, wire::shown(hello.version), hello.protocol, kVersion,
        wire::kProtocolVersion);
  }
}

void RemoteEvaluator::take(const wire::ChainRequest& request) {
  const auto worker = workers_.find(WorkerId{request.worker});
  if (!is_ours(request.protocol, request.run_id, request.chain)) {
    reject("a request for a chain that this run does not hold", request.worker);
  } else if (worker != workers_.end()) {
    worker->second.request_blocks(request.first, request.count);
  }  // else its Hello is still on the way: it asks again
}

void RemoteEvaluator::take(const wire::Answer& answer) {
  if (!is_ours(answer.protocol, answer.run_id, answer.chain)) {
    reject("an answer of another run", answer.worker);
    return;
  }
  const auto found = workers_.find(WorkerId{answer.worker});
  RemoteWorker* worker = found == workers_.end() ? nullptr : &found->second;
  const BatchId batch{answer.batch};
  const WorkerId id{answer.worker};
  switch (answer.outcome) {
    case coppice_wire_EVALUATED:
      settle(answer, worker);
      return;
    case coppice_wire_CHAIN_UNKNOWN:
      if (worker != nullptr) {
        worker->lacks_chain();  // until its next Hello says otherwise
      }
      break;
    case coppice_wire_GIVEN_BACK:
      break;
    case coppice_wire_REFUSED: {
      const auto text = wire::view(answer.payload);
      const std::string reason(text.begin(), text.begin() + std::min(std::ssize(text), kMostReason));
      reject(fmt::format("it refused a batch: {}", wire::shown(reason.c_str())), answer.worker);
      ban(id, "refused a batch");
      return;
    }
  }
  if (flight_.give_back(batch, id)) {
    ++statistics_.requeued;
  }
}

void RemoteEvaluator::settle(const wire::Answer& answer, RemoteWorker* worker) {
  const BatchId id{answer.batch};
  const WorkerId from{answer.worker};
  const auto out = flight_.find(id, from);
  if (!out || !out->current) {
    flight_.settle(id, from);  // of an earlier generation: frees the worker's credit
    ++statistics_.duplicates;
    return;
  }
  const auto tallies = wire::decode_tallies(wire::view(answer.payload), out->batch.count, job_.objectives.size());
  if (!tallies || !fits(*tallies, out->batch)) {
    reject(tallies ? "an answer to another batch" : tallies.error().message, answer.worker);
    ban(from, "sent a damaged answer");
    return;
  }
  const auto settlement = flight_.settle(id, from);
  if (settlement.fresh.empty()) {
    ++statistics_.duplicates;
    return;
  }
  last_settled_ = Clock::now();
  for (const std::uint32_t slot : settlement.fresh) {
    tallies_[slot] = (*tallies)[slot - out->batch.first];
  }
  if (worker != nullptr) {
    // No longer than it was away, whatever it says.
    const auto away = static_cast<std::uint64_t>(std::chrono::nanoseconds(last_settled_ - out->sent).count());
    worker->measured(std::chrono::nanoseconds(std::min(answer.elapsed_ns, away)), out->batch.count, job_steps_);
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

// A worker that answers nonsense would do so again: its Hellos are not heard any more.
void RemoteEvaluator::ban(WorkerId id, const std::string& why) {
  if (banned_.size() < kMaxRemembered) {
    banned_.insert(id);
  }
  lose(id, why, InFlight::Farewell::left);
}

// A process of our own is known to be dead before its lease tells.
void RemoteEvaluator::lose_process(pid_t pid) {
  const auto found =
      std::find_if(workers_.begin(), workers_.end(), [&](const auto& entry) { return entry.second.pid() == pid; });
  if (found != workers_.end()) {
    lose(found->first, "died", InFlight::Farewell::died);
  }
}

void RemoteEvaluator::lose(WorkerId id, const std::string& why, InFlight::Farewell farewell) {
  const auto worker = workers_.find(id);
  if (worker == workers_.end()) {
    return;
  }
  const auto loss = flight_.lose_worker(id, farewell);
  ++statistics_.workers_lost;
  statistics_.requeued += loss.batches;
  spdlog::warn("worker {} {}; {} batches go to others", worker->second.name(), why, loss.batches);
  workers_.erase(worker);
  for (const std::uint32_t slot : loss.poisonous) {
    spdlog::error("slot {} is given the worst fitness: {} workers were lost while they held it", slot,
                  options_.limits.attempts);
    Tally& tally = tallies_[slot];
    tally.nodes = static_cast<std::uint32_t>(trees_[slot].size());
    tally.scores.assign(job_.objectives.size(), 0);
  }
}

Result<void> RemoteEvaluator::tend(Clock::time_point now) {
  if (now < next_tending_) {
    return {};
  }
  next_tending_ = now + kTendInterval;
  if (std::exchange(announce_again_, false)) {
    if (auto ok = announce(); !ok) {
      spdlog::warn("{}", ok.error().message);
    }
  }
  if (local_) {
    for (const LocalWorkers::Ended& ended : local_->tend()) {
      spdlog::warn("{}", ended.what);
      lose_process(ended.pid);
    }
  }
  lose_hanging(now);
  return wait_for_worker(now);
}

// A worker that says Hello but stands still hangs, or never got what was sent. Its work goes to others; its next Hello
// makes it a worker like any other again. The limit doubles, so that individuals that take very long are not sent
// again and again.
void RemoteEvaluator::lose_hanging(Clock::time_point now) {
  std::vector<WorkerId> hanging;
  for (const auto& [id, worker] : workers_) {
    const auto usual = worker.cost_of(job_steps_) * kPatienceFactor;
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

Result<void> RemoteEvaluator::wait_for_worker(Clock::time_point now) {
  if (now - last_settled_ > options_.wait_limit && !workers_.empty()) {
    return failed(fmt::format("no batch was answered for {} s; what was evaluated is kept",
                              std::chrono::duration_cast<std::chrono::seconds>(options_.wait_limit).count()));
  }
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
  if (now - *without_worker_since_ > options_.wait_limit) {
    return failed(fmt::format("no worker within {} s; what was evaluated is kept",
                              std::chrono::duration_cast<std::chrono::seconds>(options_.wait_limit).count()));
  }
  if (now >= next_notice_) {
    next_notice_ = now + kNoticeInterval;
    spdlog::warn("no worker is there; waiting. Start one: coppice-worker --coordinator {} --domain {}",
                 options_.interface == "lo" ? "127.0.0.1" : wire::host_name(), domain_);
  }
  return {};
}

std::chrono::nanoseconds RemoteEvaluator::patience_for(const RemoteWorker& worker, std::uint32_t slots) const {
  const auto each = worker.cost_of(job_steps_);
  if (each.count() == 0) {
    return kPatienceUnmeasured;
  }
  const auto batches_before = static_cast<std::int64_t>(flight_.load(worker.id()) + 1);
  const double work = static_cast<double>(each.count()) * slots * static_cast<double>(batches_before) * kPatienceFactor;
  const double longest = static_cast<double>(std::chrono::nanoseconds(kLongestPatience).count());
  return std::max<std::chrono::nanoseconds>(
      kShortestPatience, std::chrono::nanoseconds(static_cast<std::int64_t>(std::min(work, longest))));
}

void RemoteEvaluator::hand_out(Clock::time_point now) {
  std::size_t lanes = 0;
  for (const auto& [id, worker] : workers_) {
    lanes += worker.ready() ? worker.lanes() : 0;
  }
  if (lanes == 0) {
    return;
  }
  // A batch for everybody before a second one for anybody.
  for (bool gave = true; gave && flight_.waiting() > 0;) {
    gave = false;
    for (auto& [id, worker] : workers_) {
      if (!worker.ready() || !flight_.can_take(id)) {
        continue;
      }
      const std::uint32_t wanted = batch_size({flight_.waiting(), lanes, worker.cost_of(job_steps_)});
      const std::uint32_t most = std::min(wanted, most_per_task_);
      if (const auto batch = flight_.offer(id, most, now, patience_for(worker, most))) {
        gave = send(worker, *batch) || gave;
      }
    }
  }
  if (flight_.waiting() == 0 && !flight_.done()) {
    for (auto& [id, worker] : workers_) {
      if (!worker.ready()) {
        continue;
      }
      const std::uint32_t usual = batch_size({flight_.unsettled(), lanes, worker.cost_of(job_steps_)});
      if (const auto copy = flight_.offer_copy(id, now, patience_for(worker, usual))) {
        spdlog::debug("worker {} gets a copy of an overdue batch", worker.name());
        send(worker, *copy);
      }
    }
  }
}

bool RemoteEvaluator::send(RemoteWorker& worker, const Batch& batch) {
  const auto payload = wire::encode_task(job_, trees_.subspan(batch.first, batch.count));
  if (auto ok = worker.send_task(batch, payload, run_, Clock::now()); !ok) {
    spdlog::warn("worker {}: {}", worker.name(), ok.error().message);
    flight_.give_back(batch.id, worker.id());
    return false;
  }
  ++statistics_.batches;
  if (options_.batch_sent) {
    options_.batch_sent(worker.pid());
  }
  return true;
}

std::chrono::nanoseconds RemoteEvaluator::time_to_sleep(Clock::time_point now) const {
  std::chrono::nanoseconds sleep = kTendInterval;
  if (const auto due = flight_.next_due(); due && *due > now) {
    sleep = std::min<std::chrono::nanoseconds>(sleep, *due - now);
  }
  return sleep;
}

}  // namespace coppice
