// A task's way to a worker, transport aside: its trees are packed, and unpacked and checked as foreign bytes must be.
// Reports ns a tree, and the ratio to copying the trees, which is the least that handing them over could cost.
#include <benchmark/benchmark.h>
#include <chrono>

#include "common/wire/codec.hpp"
#include "tests/bench/thesis_population.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kTrees = 100;      // a generation of the thesis
constexpr std::size_t kGenerations = 8;  // in turn: a processor soon knows the branches of one by heart

struct Scene {
  std::shared_ptr<const Chain> chain = bench::uav_chain();
  std::vector<std::vector<Tree>> generations;

  Scene() {
    const auto bred = bench::bred_trees(chain, kTrees * kGenerations);
    for (std::size_t i = 0; i < kGenerations; ++i) {
      const auto begin = bred.begin() + static_cast<std::ptrdiff_t>(i * kTrees);
      generations.emplace_back(begin, begin + kTrees);
    }
  }
};
const Scene& scene() {
  static const Scene made;
  return made;
}

void report(benchmark::State& state, Clock::duration ours, Clock::duration copying) {
  const double trees = static_cast<double>(state.iterations()) * kTrees;
  state.counters["ns_per_tree"] = static_cast<double>(std::chrono::nanoseconds(ours).count()) / trees;
  state.counters["times_a_copy"] = static_cast<double>(ours.count()) / static_cast<double>(copying.count());
}

Clock::duration time_of_copy(const std::vector<Tree>& trees) {
  const Clock::time_point start = Clock::now();
  std::vector<Tree> copy = trees;
  benchmark::DoNotOptimize(copy.data());
  benchmark::ClobberMemory();
  return Clock::now() - start;
}

void pack_trees(benchmark::State& state) {
  const auto& [chain, generations] = scene();
  Clock::duration ours{};
  Clock::duration copying{};
  std::size_t next = 0;
  for (auto _ : state) {
    const auto& trees = generations[next++ % kGenerations];
    const Clock::time_point start = Clock::now();
    benchmark::DoNotOptimize(wire::encode_task(Job{}, trees));
    ours += Clock::now() - start;
    copying += time_of_copy(trees);
  }
  report(state, ours, copying);
}
BENCHMARK(pack_trees);

void unpack_and_check_trees(benchmark::State& state) {
  const auto& [chain, generations] = scene();
  std::vector<std::vector<std::uint8_t>> payloads;
  for (const auto& trees : generations) {
    payloads.push_back(wire::encode_task(Job{}, trees));
  }
  wire::TaskDecoder decoder(chain->vocabulary());
  Clock::duration ours{};
  Clock::duration copying{};
  std::size_t next = 0;
  for (auto _ : state) {
    const std::size_t generation = next++ % kGenerations;
    const Clock::time_point start = Clock::now();
    auto task = decoder.decode(payloads[generation]);
    benchmark::DoNotOptimize(task->trees.data());
    decoder.recycle(std::move(*task));
    ours += Clock::now() - start;
    copying += time_of_copy(generations[generation]);
  }
  report(state, ours, copying);
}
BENCHMARK(unpack_and_check_trees);

}  // namespace
}  // namespace coppice

BENCHMARK_MAIN();
