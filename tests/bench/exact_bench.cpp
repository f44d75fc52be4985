// Expected values against what they replace, on a chain learned in the UAV room, one tree at a time:
//  * exact_steps           100 steps by sparse products, against the same by a dense matrix
//  * exact_over_rollouts   the same, against the roll-outs that bring the standard error of agreement to 0.001 and
//  0.0001
//  * discounted, long_run  one sparse LU, against sparse products until what is left is below 1e-6
#include <benchmark/benchmark.h>
#include <chrono>
#include <cmath>

#include "common/chain/exact.hpp"
#include "common/check.hpp"
#include "common/fitness/evaluation.hpp"
#include "common/tree/action_table.hpp"
#include "coordinator/learning/learn.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kSteps = 100;
constexpr std::uint32_t kRollouts = 500;
constexpr double kGamma = 0.99;
constexpr int kTrees = 64;

double seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

struct Case {
  std::shared_ptr<const PreparedChain> chain;
  std::vector<Tree> trees;
  std::vector<std::vector<std::uint8_t>> tables;
};

const Case& the_case() {
  static const Case made = [] {
    Case result;
    LearnSettings settings = default_settings(WorldKind::uav, Algorithm::q_learning);
    settings.episodes = 100'000;
    const auto world = load_world("uav");
    COPPICE_CHECK(world.has_value());
    auto learned = learn(*world, settings, {});
    COPPICE_CHECK(learned.has_value());
    result.chain = PreparedChain::make(std::make_shared<const Chain>(std::move(learned->chain)));
    result.trees = oracles::random_trees(result.chain->chain().vocabulary(), kTrees, 1);
    for (const Tree& tree : result.trees) {
      result.tables.emplace_back(result.chain->chain().states());
      fill_action_table(tree, result.chain->columns(), static_cast<std::uint8_t>(result.chain->chain().actions()),
                        result.tables.back());
    }
    return result;
  }();
  return made;
}

void exact_steps(benchmark::State& state) {
  const Case& made = the_case();
  const Chain& chain = made.chain->chain();
  const std::size_t states = chain.states();
  ExactOccupancy exact(chain);
  Clock::duration sparse{};
  Clock::duration in_dense{};
  std::size_t next = 0;
  for (auto _ : state) {
    const auto& table = made.tables[next++ % made.tables.size()];
    const Clock::time_point begin = Clock::now();
    benchmark::DoNotOptimize(exact.over_steps({table, {}, 0.0}, kSteps).visits.data());
    sparse += Clock::now() - begin;
    state.PauseTiming();
    std::vector<double> dense(states * states, 0.0);  // making it is not counted
    for (std::size_t s = 0; s < states; ++s) {
      const std::size_t row = s * chain.actions() + table[s];
      for (std::size_t to = 0; to < states && table[s] < chain.actions() && chain.tries(row) == 0; ++to) {
        dense[s * states + to] = 1.0 / static_cast<double>(states);
      }
      if (table[s] == chain.actions()) {
        dense[s * states + s] = 1.0;
        continue;
      }
      for (std::size_t i = 0; i < chain.successors(row).size(); ++i) {
        dense[s * states + chain.successors(row)[i]] = chain.counts(row)[i] / static_cast<double>(chain.tries(row));
      }
    }
    const Clock::time_point middle = Clock::now();
    std::vector<double> now(states, 0.0);
    std::vector<double> sum(states, 0.0);
    now[chain.initial_state()] = 1.0;
    for (std::uint32_t step = 0; step < kSteps; ++step) {
      std::vector<double> later(states, 0.0);
      for (std::size_t s = 0; s < states; ++s) {
        sum[s] += now[s];
        for (std::size_t to = 0; to < states; ++to) {
          later[to] += now[s] * dense[s * states + to];
        }
      }
      now.swap(later);
    }
    benchmark::DoNotOptimize(sum.data());
    in_dense += Clock::now() - middle;
    state.ResumeTiming();
  }
  state.counters["times_faster_than_dense"] = seconds(in_dense) / seconds(sparse);
}
BENCHMARK(exact_steps)->Unit(benchmark::kMicrosecond)->Iterations(128);

void exact_over_rollouts(benchmark::State& state) {
  const Case& made = the_case();
  Job job;
  job.steps = kSteps;
  job.method = Method::exact;
  Evaluation exact(*PreparedJob::make(made.chain, job));
  job.method = Method::rollouts;
  job.rollouts = kRollouts;
  Evaluation walks(*PreparedJob::make(made.chain, job));
  Clock::duration in_exact{};
  Clock::duration in_walks{};
  double squares = 0.0;  // of the difference of the mean of kRollouts walks to the expected value
  std::size_t next = 0;
  for (auto _ : state) {
    const Tree& tree = made.trees[next++ % made.trees.size()];
    const Clock::time_point begin = Clock::now();
    const Tally computed = exact.evaluate(tree);
    const Clock::time_point middle = Clock::now();
    const Tally walked = walks.evaluate(tree);
    in_exact += middle - begin;
    in_walks += Clock::now() - middle;
    const double difference = static_cast<double>(walked.matches) / static_cast<double>(walked.steps) -
                              static_cast<double>(computed.matches) / static_cast<double>(computed.steps);
    squares += difference * difference;
  }
  const double variance = squares / static_cast<double>(state.iterations()) * kRollouts;  // of one walk
  const double walk = seconds(in_walks) / static_cast<double>(state.iterations()) / kRollouts;
  const double computed = seconds(in_exact) / static_cast<double>(state.iterations());
  state.counters["exact_us"] = 1e6 * computed;
  state.counters["walk_us"] = 1e6 * walk;
  state.counters["standard_error_of_as_costly_walks"] = std::sqrt(variance / (computed / walk));
  state.counters["times_faster_at_0.001"] = variance / 1e-6 * walk / computed;
  state.counters["times_faster_at_0.0001"] = variance / 1e-8 * walk / computed;
}
// Each tree once: a second time it would be remembered.
BENCHMARK(exact_over_rollouts)->Unit(benchmark::kMicrosecond)->Iterations(kTrees);

void discounted(benchmark::State& state) {
  const Case& made = the_case();
  ExactOccupancy exact(made.chain->chain());
  Clock::duration by_lu{};
  Clock::duration by_products{};
  const auto steps = static_cast<std::uint32_t>(std::log(1e-6) / std::log(kGamma));
  std::size_t next = 0;
  for (auto _ : state) {
    const auto& table = made.tables[next++ % made.tables.size()];
    const Clock::time_point begin = Clock::now();
    benchmark::DoNotOptimize(exact.discounted({table, {}, 0.0}, kGamma));
    const Clock::time_point middle = Clock::now();
    benchmark::DoNotOptimize(exact.over_steps({table, {}, 0.0}, steps).visits.data());
    by_lu += middle - begin;
    by_products += Clock::now() - middle;
  }
  state.counters["lu_us"] = 1e6 * seconds(by_lu) / static_cast<double>(state.iterations());
  state.counters["times_faster_than_products"] = seconds(by_products) / seconds(by_lu);
}
BENCHMARK(discounted)->Unit(benchmark::kMicrosecond)->Iterations(128);

void long_run(benchmark::State& state) {
  const Case& made = the_case();
  ExactOccupancy exact(made.chain->chain());
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(exact.long_run({made.tables[next++ % made.tables.size()], {}, 0.0}));
  }
}
BENCHMARK(long_run)->Unit(benchmark::kMicrosecond)->Iterations(128);

}  // namespace
}  // namespace coppice

BENCHMARK_MAIN();
