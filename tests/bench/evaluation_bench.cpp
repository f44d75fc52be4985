// evaluate() on a chain as large as the thesis' one, against the plain way: tick the tree on every step and search the
// row of successors linearly. ns_per_step counts everything that a tree costs, its action table included.
#include <benchmark/benchmark.h>
#include <chrono>

#include "common/chain/random.hpp"
#include "common/fitness/evaluation.hpp"
#include "common/tree/tick.hpp"
#include "tests/bench/thesis_population.hpp"

namespace coppice {
namespace {

constexpr std::size_t kTrees = 400;

struct Scene {
  std::shared_ptr<const Chain> chain = bench::uav_chain();
  std::vector<Tree> trees = bench::bred_trees(chain, kTrees);
};
const Scene& scene() {
  static const Scene made;
  return made;
}

std::uint64_t plain_matches(const Chain& chain, const Job& job, const Tree& tree, Xoshiro256& random) {
  std::uint64_t matches = 0;
  for (std::uint32_t rollout = 0; rollout < job.rollouts; ++rollout) {
    std::uint32_t state = chain.initial_state();
    for (std::uint32_t step = 0; step < job.steps; ++step) {
      const ActionId action = tick(tree, chain.features_of(state));
      matches += action == chain.policy(state) ? 1 : 0;
      if (action == kNoAction) {
        continue;
      }
      const std::size_t row = chain.row(state, action);
      if (chain.tries(row) == 0) {
        state = static_cast<std::uint32_t>(random.below(chain.states()));
        continue;
      }
      std::uint64_t left = random.below(chain.tries(row));
      const auto counts = chain.counts(row);
      std::size_t i = 0;
      while (left >= counts[i]) {
        left -= counts[i++];
      }
      state = chain.successors(row)[i];
    }
  }
  return matches;
}

Job job_of(const benchmark::State& state) {
  Job job;
  job.rollouts = static_cast<std::uint32_t>(state.range(0));
  job.steps = static_cast<std::uint32_t>(state.range(1));
  job.seed = 3;
  return job;
}

void evaluate_population(benchmark::State& state, Simd simd, PreparedChain::Form form) {
  const auto& [chain, trees] = scene();
  Job job = job_of(state);
  const auto prepared = PreparedChain::make(chain, form);
  std::shared_ptr<const PreparedJob> prepared_job;
  for (auto _ : state) {
    ++job.generation;
    prepared_job = *PreparedJob::make(prepared, job, prepared_job);
    Evaluation evaluation(prepared_job, simd);
    benchmark::DoNotOptimize(evaluation.evaluate(trees));
  }
  const double steps = static_cast<double>(state.iterations()) * kTrees * job.rollouts * job.steps;
  state.counters["per_step"] = benchmark::Counter(steps, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
void vectors(benchmark::State& state) { evaluate_population(state, best_simd(), PreparedChain::Form::tables); }
void portable(benchmark::State& state) { evaluate_population(state, Simd::none, PreparedChain::Form::tables); }
void lazy(benchmark::State& state) { evaluate_population(state, Simd::none, PreparedChain::Form::lazy); }
BENCHMARK(vectors)->Args({16, 100})->Args({5, 100})->Args({100, 100});
BENCHMARK(portable)->Args({16, 100})->Args({5, 100})->Args({100, 100});
BENCHMARK(lazy)->Args({16, 100});

void plain(benchmark::State& state) {
  const auto& [chain, trees] = scene();
  const Job job = job_of(state);
  Xoshiro256 random(1);
  for (auto _ : state) {
    for (const Tree& tree : trees) {
      benchmark::DoNotOptimize(plain_matches(*chain, job, tree, random));
    }
  }
  const double steps = static_cast<double>(state.iterations()) * kTrees * job.rollouts * job.steps;
  state.counters["per_step"] = benchmark::Counter(steps, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(plain)->Args({16, 100});

// Both in turn, a generation each.
void evaluation_against_plain(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  const auto& [chain, trees] = scene();
  Job job = job_of(state);
  const auto prepared = PreparedChain::make(chain);
  std::shared_ptr<const PreparedJob> prepared_job;
  Xoshiro256 random(1);
  Clock::duration ours{};
  Clock::duration plainly{};
  for (auto _ : state) {
    const Clock::time_point start = Clock::now();
    ++job.generation;
    prepared_job = *PreparedJob::make(prepared, job, prepared_job);
    Evaluation evaluation(prepared_job);
    benchmark::DoNotOptimize(evaluation.evaluate(trees));
    const Clock::time_point middle = Clock::now();
    for (const Tree& tree : trees) {
      benchmark::DoNotOptimize(plain_matches(*chain, job, tree, random));
    }
    ours += middle - start;
    plainly += Clock::now() - middle;
  }
  state.counters["times_faster"] = static_cast<double>(plainly.count()) / static_cast<double>(ours.count());
}
BENCHMARK(evaluation_against_plain)->Args({16, 100})->Args({5, 100});

}  // namespace
}  // namespace coppice

BENCHMARK_MAIN();
