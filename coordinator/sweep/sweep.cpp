#include "coordinator/sweep/sweep.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "common/check.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/simplify.hpp"
#include "common/tree/state_columns.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/report/score.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

class Sweep {
 public:
  Sweep(const Chain& chain, const World* world, const std::vector<SweepRun>& runs, const SweepSettings& settings,
        const SweepHooks& hooks, const StopFlag& stop)
      : chain_(chain),
        world_(world),
        runs_(runs),
        settings_(settings),
        hooks_(hooks),
        stop_(stop),
        columns_(chain.vocabulary(), chain.parts().features) {}

  Result<void> run() {
    COPPICE_CHECK(settings_.at_once >= 1);
    std::vector<std::unique_ptr<Evaluator>> evaluators;
    for (std::size_t i = 0; i < std::min(settings_.at_once, runs_.size()); ++i) {
      evaluators.push_back(settings_.new_evaluator());
    }
    std::vector<std::thread> threads;
    threads.reserve(evaluators.size());
    for (const auto& evaluator : evaluators) {
      threads.emplace_back([this, &evaluator] { take_runs(*evaluator); });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    if (error_) {
      return tl::unexpected(*error_);
    }
    return {};
  }

 private:
  bool ended() const {
    const std::lock_guard lock(mutex_);
    return error_.has_value();
  }

  void end(const Error& error) {
    const std::lock_guard lock(mutex_);
    if (!error_) {
      error_ = error;
    }
  }

  void take_runs(Evaluator& evaluator) {
    for (std::size_t run = next_++; run < runs_.size() && !ended(); run = next_++) {
      const auto result = evolve_one(run, evaluator);
      if (!result) {
        end(result.error());
        return;
      }
      const std::lock_guard lock(hooks_mutex_);
      if (ended()) {
        return;
      }
      if (hooks_.run_done) {
        if (auto ok = hooks_.run_done(run, *result); !ok) {
          end(ok.error());
          return;
        }
      }
    }
  }

  Result<SweepResult> evolve_one(std::size_t run, Evaluator& evaluator) {
    const EvolveConfig& config = runs_[run].config;
    const Clock::time_point begin = Clock::now();
    SweepResult result;
    EvolveHooks hooks;
    hooks.whole = true;
    hooks.count_meanings = true;
    hooks.generations_done = [&](std::span<const GenerationRecord> records,
                                 const Checkpoint& checkpoint) -> Result<void> {
      const auto individuals = static_cast<double>(checkpoint.population.size());
      for (const GenerationRecord& record : records) {
        result.distinct += static_cast<double>(record.distinct_trees) / individuals;
        result.meanings += static_cast<double>(record.meanings) / individuals;
      }
      if (stop_.raised() || ended()) {
        return interrupted();
      }
      const std::lock_guard lock(hooks_mutex_);
      for (std::size_t i = 0; hooks_.generation_done && i < records.size(); ++i) {
        hooks_.generation_done(run, records[i]);
      }
      return {};
    };
    const auto evolved = evolve(chain_, config, evaluator, std::nullopt, hooks);
    if (!evolved) {
      return tl::unexpected(evolved.error());
    }
    if (evolved->interrupted) {
      return interrupted();
    }
    result.distinct /= evolved->generations_done;
    result.meanings /= evolved->generations_done;
    result.fitness = evolved->best.fitness;
    result.agreement = evolved->best.agreement;
    result.tree = simplify(evolved->best.tree, chain_.vocabulary(), columns_).tree;
    result.nodes = result.tree.size();
    result.coverage = static_cast<double>(matching_states(chain_, actions_of(chain_, result.tree))) /
                      static_cast<double>(chain_.states());
    if (world_ != nullptr) {
      const auto episodes = simulate_tree(*world_, chain_, result.tree,
                                          {.episodes = settings_.episodes, .steps = settings_.steps, .stop = &stop_},
                                          [&] { return !stop_.raised() && !ended(); });
      if (!episodes) {
        return tl::unexpected(episodes.error());
      }
      const ControllerScore score = controller_score(*episodes);
      result.simulated = SweepResult::Simulated{score.agreement.mean, score.reward.mean, score.collisions.mean};
    }
    result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return result;
  }

  const Chain& chain_;
  const World* world_;
  const std::vector<SweepRun>& runs_;
  const SweepSettings& settings_;
  const SweepHooks& hooks_;
  const StopFlag& stop_;
  const StateColumns columns_;

  std::atomic<std::size_t> next_{0};
  std::mutex hooks_mutex_;
  mutable std::mutex mutex_;
  std::optional<Error> error_;
};

}  // namespace

Result<void> sweep(const Chain& chain, const World* world, const std::vector<SweepRun>& runs,
                   const SweepSettings& settings, const SweepHooks& hooks, const StopFlag& stop) {
  return Sweep(chain, world, runs, settings, hooks, stop).run();
}

}  // namespace coppice
