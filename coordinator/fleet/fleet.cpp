#include "coordinator/fleet/fleet.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <random>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "common/fitness/golden_job.hpp"
#include "common/version.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"

namespace coppice {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds kSettlingInterval{5};  // new workers are looked at this often
constexpr std::chrono::milliseconds kListenAtHome{10};     // workers are heard this often meanwhile
constexpr std::chrono::seconds kWatchInterval{1};
constexpr int kMostSteps = 64;  // in a row, without listening, while what was done makes events
// A tree's meaning is found in about 0.8 us; individuals whose walks take fewer steps are evaluated sooner than that
// saves. The worker that holds several of one meaning evaluates them once all the same.
constexpr std::uint64_t kStepsWorthSeeking = 5000;
constexpr std::chrono::microseconds kPaceWorthSeeking{20};

std::uint64_t random_seed() {
  std::random_device device;
  const std::uint64_t high = device();
  return high << 32U | device();
}

DispatchSettings settings_of(const FleetOptions& options, std::uint32_t domain) {
  DispatchSettings settings;
  settings.limits = options.limits;
  settings.wait_limit = options.wait_limit;
  settings.cross_check = options.cross_check;
  settings.seed = random_seed();
  settings.places = options.local_workers;
  settings.protocol = wire::kProtocolVersion;
  settings.golden = golden_checksum();
  settings.version = kVersion;
  const wire::Network& network = options.network;
  const std::vector<std::string> addresses = wire::addresses_of(options.interface);
  settings.invitation = fmt::format("coppice-worker --coordinator {} --domain {}{}{}",
                                    !network.advertise.empty() ? network.advertise
                                    : addresses.empty()        ? options.interface
                                                               : addresses.front(),
                                    domain,
                                    network.lossy ? " --lossy" : "", network.security.empty() ? "" : " --security DIR");
  settings.absence = fmt::format(
      "One that runs and is not here cannot reach UDP port {} of {} (firewall, another --interface or --domain here), "
      "cannot be reached itself (firewall: its --port), {}, or differs in --lossy",
      wire::coordinator_port(domain), options.interface,
      network.security.empty() ? "has --security, which this coordinator has not"
                               : "has no identity (--security), one that ended, or one of another authority");
  return settings;
}

}  // namespace

Fleet::Fleet(std::shared_ptr<const Chain> chain, FleetOptions options, const StopFlag& stop, Endpoints endpoints,
             std::unique_ptr<Evaluator> reference)
    : chain_(std::move(chain)),
      chain_bytes_(to_bytes(*chain_)),
      options_(std::move(options)),
      stop_(stop),
      run_{wire::random_identity(), hash_of(chain_bytes_)},
      dds_(std::move(endpoints)),
      wake_(stop.on_raise([this] { dds_.waiter.wake(); })),
      dispatcher_(settings_of(options_, dds_.domain)),
      meanings_(*chain_),
      reference_(std::move(reference)),
      home_(*reference_),
      certificates_(options_.network.security) {
  onlookers_.watch(options_.watch_workers);
}

Fleet::~Fleet() {
  if (options_.watch) {
    options_.watch(status());
  }
  local_.reset();  // while DDS still acknowledges what the workers say last
}

Result<std::unique_ptr<Fleet>> Fleet::open(std::shared_ptr<const Chain> chain, FleetOptions options,
                                           const StopFlag& stop) {
  auto reference = SerialEvaluator::make(chain, stop);
  if (!reference) {
    return tl::unexpected(reference.error());
  }
  auto endpoints = Endpoints::open(options.domain, options.interface, options.network);
  if (!endpoints) {
    return tl::unexpected(endpoints.error());
  }
  std::unique_ptr<Fleet> fleet(
      new Fleet(std::move(chain), std::move(options), stop, std::move(*endpoints), std::move(*reference)));
  if (auto ok = fleet->announce(); !ok) {
    return tl::unexpected(ok.error());
  }
  if (fleet->options_.local_workers > 0) {
    // Those that may never be needed are started when something is sent.
    if (auto ok = fleet->options_.may_stay_home ? LocalWorkers::check(fleet->options_.worker_program)
                                                : fleet->start_workers();
        !ok) {
      return tl::unexpected(ok.error());
    }
  }
  return fleet;
}

Result<void> Fleet::start_workers() {
  if (local_ || options_.local_workers == 0) {
    return {};
  }
  auto flags = options_.worker_flags;
  flags.resize(options_.local_workers);
  auto local = LocalWorkers::start(options_.worker_program, flags, domain(), options_.worker_threads);
  if (!local) {
    return tl::unexpected(local.error());
  }
  local_.emplace(std::move(*local));
  const std::vector<pid_t> pids = local_->pids();
  for (std::size_t place = 0; place < pids.size(); ++place) {
    events_.emplace_back(ProcessStarted{place, pids[place]});
  }
  return {};
}

Result<void> Fleet::announce() {
  wire::Control control{};
  control.protocol = wire::kProtocolVersion;
  control.run_id = run_.run_id;
  wire::put_text(control.version, kVersion);
  wire::put_text(control.host, wire::host_name());
  control.pid = static_cast<std::uint32_t>(getpid());
  control.chain = wire::to_wire(run_.chain);
  control.chain_size = chain_bytes_.size();
  control.golden = golden_checksum();
  return dds_.control.write(control);
}

Result<void> Fleet::check_objectives(const Job& job) {
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

bool Fleet::worth_seeking_repeats(const Job& job) const {
  return job.method != Method::rollouts || tally_steps(job) >= kStepsWorthSeeking ||
         dispatcher_.somebody_takes(EvaluationWork::class_of(job), kPaceWorthSeeking);
}

Result<RequestId> Fleet::submit(std::span<const Tree> trees, const Job& job) {
  if (auto ok = check_objectives(job); !ok) {
    return tl::unexpected(ok.error());
  }
  return submit(std::make_unique<EvaluationWork>(trees, job, worth_seeking_repeats(job),
                                                 EvaluationWork::Here{chain_->vocabulary(), meanings_, *reference_}));
}

Result<std::optional<std::vector<Tally>>> Fleet::evaluate_at_home(std::span<const Tree> trees, const Job& job) {
  if (!options_.may_stay_home || trees.empty()) {
    return std::nullopt;
  }
  if (auto ok = check_objectives(job); !ok) {
    return tl::unexpected(ok.error());
  }
  if (Clock::now() >= next_listening_at_home_) {
    dispatcher_.needs_nobody();
    if (auto ok = act(); !ok) {
      return tl::unexpected(ok.error());
    }
    next_listening_at_home_ = Clock::now() + kListenAtHome;
  }
  auto tallies = home_.evaluate(trees, job, dispatcher_.ready_lanes());
  if (tallies && home_.would_gain(trees.size(), job, options_.local_workers)) {
    if (auto ok = start_workers(); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  return tallies;
}

void Fleet::took_workers(std::size_t trees, const Job& job, std::chrono::nanoseconds elapsed) {
  if (options_.may_stay_home) {
    home_.took_workers(trees, job, elapsed);
  }
}

RequestId Fleet::submit(std::unique_ptr<RequestWork> work) {
  if (auto ok = start_workers(); !ok) {
    for (std::size_t place = 0; place < options_.local_workers; ++place) {
      events_.emplace_back(ProcessEnded{place, 0, false, ok.error().message});
    }
  }
  if (works_.empty()) {
    matching_changed_ = true;
  }
  const RequestId id = dispatcher_.open(work->terms(), Clock::now());
  works_.emplace(id, std::move(work));
  return id;
}

void Fleet::look_up_portions() {
  for (auto& [id, work] : works_) {
    if (dispatcher_.requests().at(id).sealed) {
      continue;
    }
    if (!work->all_seen()) {
      dispatcher_.add(id, work->look_up_portion());
    }
    if (work->all_seen()) {
      dispatcher_.seal(id);
    }
  }
}

bool Fleet::done(RequestId id) const { return dispatcher_.done(id); }

Fleet::Finished Fleet::take(RequestId id) {
  auto [outcomes, repeated] = dispatcher_.take(id);
  auto work = works_.extract(id);
  return {std::move(work.mapped()), std::move(outcomes), repeated};
}

Fleet::Evaluated Fleet::take_tallies(RequestId id) {
  Finished finished = take(id);
  const auto& work = dynamic_cast<const EvaluationWork&>(*finished.work);
  Evaluated evaluated{work.tallies(std::move(finished.outcomes)), finished.repeated + work.repeated()};
  statistics_.individuals += evaluated.tallies.size();
  statistics_.repeated += evaluated.repeated;
  return evaluated;
}

void Fleet::abandon() {
  dispatcher_.abandon();
  works_.clear();
  apart_.clear();
}

std::vector<pid_t> Fleet::ready_pids() const {
  std::vector<pid_t> pids;
  for (const auto& [id, worker] : dispatcher_.roster().all()) {
    if (worker.ready()) {
      pids.push_back(worker.pid);
    }
  }
  return pids;
}

Result<void> Fleet::await_workers(std::size_t count) {
  if (auto ok = start_workers(); !ok) {
    return ok;
  }
  while (ready_pids().size() < count) {
    if (auto ok = act(); !ok) {
      return ok;
    }
    sleep();
  }
  return {};
}

DispatchStatistics Fleet::statistics() const {
  DispatchStatistics statistics = dispatcher_.statistics();
  statistics.individuals = statistics_.individuals + home_.statistics().individuals;
  statistics.repeated = statistics_.repeated + home_.statistics().repeated;
  statistics.sent_bytes = statistics_.sent_bytes;
  statistics.at_home += home_.statistics().at_home;
  return statistics;
}

Result<void> Fleet::act() {
  if (stop_.raised()) {
    return interrupted();
  }
  listen();
  look_up_portions();
  for (int step = 0; step < kMostSteps; ++step) {
    std::vector<DispatchEvent> events = std::exchange(events_, {});
    Actions actions = dispatcher_.step(events, Clock::now());
    if (auto ok = perform(actions); !ok) {
      return ok;
    }
    if (actions.failure) {
      return tl::unexpected(in_words(*actions.failure));
    }
    wake_at_ = actions.wake_at;
    if (events_.empty()) {
      break;
    }
  }
  const auto now = Clock::now();
  if (const std::string line = certificates_.look(); !line.empty()) {
    spdlog::warn("{}", line);
  }
  onlookers_.show(dds_, run_, dispatcher_, now);
  if (options_.watch && now >= next_watch_) {
    next_watch_ = now + kWatchInterval;
    options_.watch(status());
  }
  return {};
}

FleetStatus Fleet::status() const {
  FleetStatus status;
  status.statistics = statistics();
  status.epochs = epochs_;
  status.sources = dispatcher_.sources();
  for (const auto& [id, worker] : dispatcher_.roster().all()) {
    const std::size_t batches = dispatcher_.flight().load(id);
    ++(!worker.ready() ? status.joining : batches > 0 ? status.evaluating : status.idle);
    if (worker.ready()) {
      status.lanes += worker.lanes;
      status.lanes_busy += std::min(worker.lanes, batches);
    }
    status.in_flight += dispatcher_.flight().backlog(id);
  }
  status.waiting = dispatcher_.flight().waiting();
  status.requests = works_.size();
  return status;
}

void Fleet::sleep() {
  const bool all_seen =
      std::all_of(works_.begin(), works_.end(), [](const auto& work) { return work.second->all_seen(); });
  if (!all_seen || !events_.empty()) {
    return;
  }
  std::chrono::nanoseconds time = std::max<std::chrono::nanoseconds>(wake_at_ - Clock::now(), 0ns);
  if (settling_) {
    time = std::min<std::chrono::nanoseconds>(time, kSettlingInterval);
  }
  matching_changed_ = dds_.waiter.wait(time);
}

}  // namespace coppice
