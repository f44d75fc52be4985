// The action table of a tree over the states of a chain as large as the thesis' one, against tick() on every state.
// Reports ns per node, and in the last benchmark the ratio of the two.
#include <benchmark/benchmark.h>
#include <chrono>

#include "common/chain/random.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/simplify.hpp"
#include "common/tree/tick.hpp"

namespace coppice {
namespace {

constexpr std::size_t kStates = 1041;
constexpr std::size_t kFeatures = 8;

struct Case {
  Vocabulary vocabulary;
  std::vector<std::uint8_t> rows;
  std::vector<Tree> trees;
  std::size_t nodes = 0;
};

// Trees of about `size` nodes.
Case make_case(std::size_t size) {
  Case made;
  for (std::size_t f = 0; f < kFeatures; ++f) {
    made.vocabulary.features.push_back({std::string("s").append(std::to_string(f)), {0, 1, 3}});
  }
  made.vocabulary.actions = {"move", "turn_left", "turn_right"};
  Xoshiro256 random(1);
  const Below below = [&random](std::uint64_t n) { return random.below(n); };
  for (std::size_t i = 0; i < kStates * kFeatures; ++i) {
    made.rows.push_back(made.vocabulary.features[0].values[below(3)]);
  }
  while (made.trees.size() < 64) {
    Tree tree = grow_tree(made.vocabulary, {5, 4}, true, below);
    if (tree.size() >= size - size / 10 && tree.size() <= size + size / 10) {
      made.nodes += tree.size();
      made.trees.push_back(std::move(tree));
    }
  }
  return made;
}

void tick_all(const Case& made, const Tree& tree, std::vector<std::uint8_t>& table) {
  for (std::size_t s = 0; s < kStates; ++s) {
    table[s] = static_cast<std::uint8_t>(
        tick(tree, std::span<const std::uint8_t>(made.rows).subspan(s * kFeatures, kFeatures)));
  }
}

void report_per_node(benchmark::State& state, const Case& made) {
  const double nodes_per_tree = static_cast<double>(made.nodes) / static_cast<double>(made.trees.size());
  state.counters["per_node"] = benchmark::Counter(static_cast<double>(state.iterations()) * nodes_per_tree,
                                                  benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void action_table_of_trees(benchmark::State& state) {
  const Case made = make_case(static_cast<std::size_t>(state.range(0)));
  const StateColumns columns(made.vocabulary, made.rows);
  std::vector<std::uint8_t> table(kStates);
  std::size_t next = 0;
  for (auto _ : state) {
    fill_action_table(made.trees[next++ % made.trees.size()], columns, 0xFF, table);
    benchmark::DoNotOptimize(table.data());
    benchmark::ClobberMemory();
  }
  report_per_node(state, made);
}
BENCHMARK(action_table_of_trees)->Arg(10)->Arg(40)->Arg(200);

void tick_on_every_state(benchmark::State& state) {
  const Case made = make_case(static_cast<std::size_t>(state.range(0)));
  std::vector<std::uint8_t> table(kStates);
  std::size_t next = 0;
  for (auto _ : state) {
    tick_all(made, made.trees[next++ % made.trees.size()], table);
    benchmark::DoNotOptimize(table.data());
    benchmark::ClobberMemory();
  }
  report_per_node(state, made);
}
BENCHMARK(tick_on_every_state)->Arg(10)->Arg(40)->Arg(200);

void action_table_against_tick(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  const Case made = make_case(static_cast<std::size_t>(state.range(0)));
  const StateColumns columns(made.vocabulary, made.rows);
  std::vector<std::uint8_t> table(kStates);
  Clock::duration in_table{};
  Clock::duration in_tick{};
  for (auto _ : state) {
    const Clock::time_point start = Clock::now();
    for (const Tree& tree : made.trees) {
      fill_action_table(tree, columns, 0xFF, table);
      benchmark::DoNotOptimize(table.data());
      benchmark::ClobberMemory();
    }
    const Clock::time_point middle = Clock::now();
    for (const Tree& tree : made.trees) {
      tick_all(made, tree, table);
      benchmark::DoNotOptimize(table.data());
      benchmark::ClobberMemory();
    }
    in_table += middle - start;
    in_tick += Clock::now() - middle;
  }
  state.counters["times_faster"] = static_cast<double>(in_tick.count()) / static_cast<double>(in_table.count());
}
BENCHMARK(action_table_against_tick)->Arg(40);

void simplify_on_states(benchmark::State& state) {
  const Case made = make_case(static_cast<std::size_t>(state.range(0)));
  const StateColumns columns(made.vocabulary, made.rows);
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(simplify(made.trees[next++ % made.trees.size()], made.vocabulary, columns));
  }
}
BENCHMARK(simplify_on_states)->Arg(40)->Arg(200)->Unit(benchmark::kMillisecond);

void simplify_soundly(benchmark::State& state) {
  const Case made = make_case(static_cast<std::size_t>(state.range(0)));
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(simplify(made.trees[next++ % made.trees.size()], made.vocabulary));
  }
}
BENCHMARK(simplify_soundly)->Arg(40)->Arg(200)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace coppice

BENCHMARK_MAIN();
