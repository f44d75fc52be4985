#include "coordinator/fleet/evaluator_pool.hpp"

#include <utility>

#include "common/wire/short_turns.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/fleet/home_evaluation.hpp"

namespace coppice {

class EvaluatorPool::Client : public Evaluator, private DemeEvolver {
 public:
  explicit Client(EvaluatorPool& pool) : pool_(pool) {
    if (pool.home_chain_ != nullptr) {
      home_evaluator_ = SerialEvaluator::make(pool.home_chain_, pool.stop_);
      home_.emplace(*home_evaluator_);
    }
  }
  ~Client() override { pool_.forget(*this); }

  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override {
    auto at_home = evaluate_at_home(trees, job);
    if (!at_home) {
      return tl::unexpected(at_home.error());
    }
    if (*at_home) {
      return std::move(**at_home);
    }
    const bool somebody_is_there = pool_.ready_lanes_ > 0;
    const auto begin = std::chrono::steady_clock::now();
    auto finished = pool_.evaluate(trees, job);
    if (!finished) {
      return tl::unexpected(finished.error());
    }
    if (home_ && somebody_is_there) {
      home_->took_workers(trees.size(), job, std::chrono::steady_clock::now() - begin);
    }
    statistics_.individuals += trees.size();
    statistics_.repeated += finished->repeated;
    return std::move(finished->tallies);
  }
  DemeEvolver* demes(const EvolveConfig& config) override {
    return FleetEvolver::fits(*pool_.chain_, config) ? this : nullptr;
  }
  DispatchStatistics statistics() const override { return statistics_; }

  std::deque<Finished> ended_epochs;  // the pool's mutex is held

 private:
  void submit(std::uint64_t ticket, std::shared_ptr<const EvolveConfig> config, EpochTask task) override {
    pool_.submit({this, ticket, std::move(config), std::move(task)});
  }
  Result<Finished> next() override {
    auto finished = pool_.next(*this);
    for (std::size_t i = 0; finished && i < finished->result.records.size(); ++i) {
      statistics_.individuals += finished->result.records[i].evaluations;
    }
    return finished;
  }

  Result<std::optional<std::vector<Tally>>> evaluate_at_home(std::span<const Tree> trees, const Job& job) {
    if (!home_) {
      return std::nullopt;
    }
    const DispatchStatistics before = home_->statistics();
    auto tallies = home_->evaluate(trees, job, pool_.ready_lanes_);
    if (tallies && *tallies) {
      const DispatchStatistics& after = home_->statistics();
      pool_.took_home(after.individuals - before.individuals, after.repeated - before.repeated);
      statistics_.individuals += after.individuals - before.individuals;
      statistics_.at_home += after.at_home - before.at_home;
      statistics_.repeated += after.repeated - before.repeated;
    }
    return tallies;
  }

  EvaluatorPool& pool_;
  std::unique_ptr<Evaluator> home_evaluator_;
  std::optional<HomeEvaluation> home_;
  DispatchStatistics statistics_;
};

Result<std::unique_ptr<EvaluatorPool>> EvaluatorPool::open(std::shared_ptr<const Chain> chain, FleetOptions options,
                                                           const StopFlag& stop) {
  const bool may_stay_home = std::exchange(options.may_stay_home, false);  // the clients', not the fleet's
  auto fleet = Fleet::open(chain, std::move(options), stop);
  if (!fleet) {
    return tl::unexpected(fleet.error());
  }
  return std::unique_ptr<EvaluatorPool>(new EvaluatorPool(std::move(*fleet), std::move(chain), may_stay_home, stop));
}

EvaluatorPool::EvaluatorPool(std::unique_ptr<Fleet> fleet, std::shared_ptr<const Chain> chain, bool may_stay_home,
                             const StopFlag& stop)
    : chain_(std::move(chain)),
      fleet_(std::move(fleet)),
      evolver_(*fleet_, chain_, stop),
      stop_(stop),
      home_chain_(may_stay_home ? PreparedChain::make(chain_) : nullptr),
      thread_([this] { run(); }) {}

EvaluatorPool::~EvaluatorPool() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  fleet_->wake();
  thread_.join();
}

std::unique_ptr<Evaluator> EvaluatorPool::client() { return std::make_unique<Client>(*this); }

DispatchStatistics EvaluatorPool::statistics() const {
  const std::lock_guard lock(mutex_);
  DispatchStatistics all = statistics_;
  all.individuals += at_home_.individuals;
  all.at_home += at_home_.individuals;
  all.repeated += at_home_.repeated;
  return all;
}

void EvaluatorPool::took_home(std::uint64_t individuals, std::uint64_t repeated) {
  const std::lock_guard lock(mutex_);
  at_home_.individuals += individuals;
  at_home_.repeated += repeated;
}

Result<Fleet::Evaluated> EvaluatorPool::evaluate(std::span<const Tree> trees, const Job& job) {
  Call call;
  call.trees = trees;
  call.job = &job;
  std::unique_lock lock(mutex_);
  if (broken_) {
    return tl::unexpected(*broken_);
  }
  const bool first = calls_.empty();
  calls_.push_back(&call);
  if (first) {
    fleet_->wake();
  }
  call.answered.wait(lock, [&] { return call.result.has_value(); });
  return std::move(*call.result);
}

void EvaluatorPool::submit(Epoch epoch) {
  {
    const std::lock_guard lock(mutex_);
    epochs_.push_back(std::move(epoch));
  }
  fleet_->wake();
}

Result<DemeEvolver::Finished> EvaluatorPool::next(Client& client) {
  std::unique_lock lock(mutex_);
  epoch_ended_.wait(lock, [&] { return broken_ || !client.ended_epochs.empty(); });
  if (broken_) {
    return tl::unexpected(*broken_);
  }
  DemeEvolver::Finished finished = std::move(client.ended_epochs.front());
  client.ended_epochs.pop_front();
  return finished;
}

// What runs for it goes on, and is of no use to anybody.
void EvaluatorPool::forget(const Client& client) {
  const std::lock_guard lock(mutex_);
  for (Epoch& epoch : epochs_) {
    epoch.client = epoch.client == &client ? nullptr : epoch.client;
  }
  for (auto& [ticket, epoch] : running_epochs_) {
    epoch.client = epoch.client == &client ? nullptr : epoch.client;
  }
}

// The call is gone as soon as its mutex is free: its owner is told before.
void EvaluatorPool::answer(Call& call, Result<Fleet::Evaluated> result) {
  call.result = std::move(result);
  call.answered.notify_one();
}

void EvaluatorPool::run() {
  const wire::ShortTurns turns;
  while (true) {
    take_calls();
    {
      const std::lock_guard lock(mutex_);
      if (ending_ || broken_) {
        return;
      }
    }
    if (auto ok = fleet_->act(); !ok) {
      fail_calls(ok.error());
      return;
    }
    answer_calls();
    ready_lanes_ = fleet_->ready_lanes();
    fleet_->sleep();
  }
}

void EvaluatorPool::take_calls() {
  const std::lock_guard lock(mutex_);
  for (Call* const call : std::exchange(calls_, {})) {
    if (const auto request = fleet_->submit(call->trees, *call->job)) {
      open_.emplace(*request, call);
    } else {
      answer(*call, tl::unexpected(request.error()));
    }
  }
  for (Epoch& epoch : std::exchange(epochs_, {})) {
    if (epoch.client != nullptr) {
      evolver_.submit(next_ticket_, std::move(epoch.config), std::move(epoch.task));
      running_epochs_.emplace(next_ticket_++, Epoch{epoch.client, epoch.ticket, nullptr, {}});
    }
  }
}

void EvaluatorPool::answer_calls() {
  for (auto open = open_.begin(); open != open_.end();) {
    if (!fleet_->done(open->first)) {
      ++open;
      continue;
    }
    auto finished = fleet_->take_tallies(open->first);
    const DispatchStatistics statistics = fleet_->statistics();
    const std::lock_guard lock(mutex_);
    statistics_ = statistics;
    answer(*open->second, std::move(finished));
    open = open_.erase(open);
  }
  while (auto ended = evolver_.take_ended()) {
    const DispatchStatistics statistics = fleet_->statistics();
    const std::lock_guard lock(mutex_);
    statistics_ = statistics;
    const auto running = running_epochs_.find(ended->ticket);
    if (Client* const client = running->second.client; client != nullptr) {
      client->ended_epochs.push_back({running->second.ticket, std::move(ended->result)});
      epoch_ended_.notify_all();
    }
    running_epochs_.erase(running);
  }
}

void EvaluatorPool::fail_calls(const Error& error) {
  fleet_->abandon();
  const std::lock_guard lock(mutex_);
  broken_ = error;
  for (const auto& [request, call] : open_) {
    answer(*call, tl::unexpected(error));
  }
  for (Call* const call : calls_) {
    answer(*call, tl::unexpected(error));
  }
  open_.clear();
  calls_.clear();
  evolver_.forget();
  epochs_.clear();
  running_epochs_.clear();
  epoch_ended_.notify_all();
}

}  // namespace coppice
