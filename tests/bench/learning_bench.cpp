// Learning in the default room and counting its chain, against the room alone: as many steps with uniform actions,
// nothing learned, nothing counted.
#include <benchmark/benchmark.h>
#include <chrono>

#include "common/chain/random.hpp"
#include "coordinator/learning/learn.hpp"
#include "coordinator/learning/rooms.hpp"
#include "coordinator/learning/uav_room.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kEpisodes = 20'000;

double walk_alone(UavRoom& room, std::uint64_t episodes, std::uint32_t steps, Xoshiro256& random) {
  double rewards = 0.0;
  for (std::uint64_t episode = 0; episode < episodes; ++episode) {
    room.reset(0);
    for (std::uint32_t step = 0; step < steps; ++step) {
      rewards += room.step(static_cast<std::uint32_t>(random.below(UavRoom::kActions)), random).reward;
    }
  }
  return rewards;
}

void learn_against_the_room(benchmark::State& state) {
  const World world = *load_world("uav");
  LearnSettings settings = default_settings(WorldKind::uav, static_cast<Algorithm>(state.range(0)));
  settings.episodes = kEpisodes;
  UavRoom room(*parse_room(default_room()));
  Xoshiro256 random(1);
  Clock::duration learning{};
  Clock::duration walking{};
  for (auto _ : state) {
    const Clock::time_point start = Clock::now();
    benchmark::DoNotOptimize(learn(world, settings, {}));
    const Clock::time_point middle = Clock::now();
    benchmark::DoNotOptimize(walk_alone(room, settings.episodes, settings.steps, random));
    learning += middle - start;
    walking += Clock::now() - middle;
  }
  const double steps = static_cast<double>(state.iterations() * settings.episodes * settings.steps);
  state.counters["ns_per_step"] = static_cast<double>(std::chrono::nanoseconds(learning).count()) / steps;
  state.counters["times_the_room"] = static_cast<double>(learning.count()) / static_cast<double>(walking.count());
}
BENCHMARK(learn_against_the_room)
    ->Arg(static_cast<int>(Algorithm::q_learning))
    ->Arg(static_cast<int>(Algorithm::sarsa))
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace coppice

BENCHMARK_MAIN();
