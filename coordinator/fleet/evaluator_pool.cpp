#include "coordinator/fleet/evaluator_pool.hpp"

#include <utility>

namespace coppice {

class EvaluatorPool::Client : public Evaluator, private DemeEvolver {
 public:
  explicit Client(EvaluatorPool& pool) : pool_(pool) {}
  ~Client() override { pool_.forget(*this); }

  Result<std::vector<Tally>> evaluate(std::span<const Tree> trees, const Job& job) override {
    auto finished = pool_.evaluate(trees, job);
    if (!finished) {
      return tl::unexpected(finished.error());
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

  EvaluatorPool& pool_;
  DispatchStatistics statistics_;
};

Result<std::unique_ptr<EvaluatorPool>> EvaluatorPool::open(std::shared_ptr<const Chain> chain, FleetOptions options,
                                                           const StopFlag& stop) {
  auto fleet = Fleet::open(chain, std::move(options), stop);
  if (!fleet) {
    return tl::unexpected(fleet.error());
  }
  return std::unique_ptr<EvaluatorPool>(new EvaluatorPool(std::move(*fleet), std::move(chain), stop));
}

EvaluatorPool::EvaluatorPool(std::unique_ptr<Fleet> fleet, std::shared_ptr<const Chain> chain, const StopFlag& stop)
    : chain_(std::move(chain)), fleet_(std::move(fleet)), evolver_(*fleet_, chain_, stop), thread_([this] { run(); }) {}

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
  return statistics_;
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
