#include "coordinator/commands/learn_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <utility>

#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/progress.hpp"

namespace coppice {
namespace {

// Which algorithm a world is learned with unless told otherwise. With a battery, states that look alike are worth
// different things, and what SARSA learns of them is what its own policy meets: README.md of learning has figures.
Algorithm usual_algorithm(WorldKind kind) {
  return kind == WorldKind::battery ? Algorithm::sarsa : Algorithm::q_learning;
}

}  // namespace

void add_learn_options(CLI::App& command, LearnOptions& options) {
  command
      .add_option("--world", options.world,
                  "The room of the thesis, a room with a battery to charge, the windy grid, or a room of yours")
      ->type_name("uav|battery|windy|FILE.room")
      ->capture_default_str();
  command.add_option("--algorithm", options.algorithm, "How to learn (default: q-learning; battery: sarsa)")
      ->type_name("q-learning|sarsa");
  command.add_option("--episodes", options.episodes, "Episodes to learn from (default: as the thesis has it)")
      ->check(whole_number());
  command.add_option("--greedy-episodes", options.greedy_episodes, "More episodes behind those, without exploration")
      ->check(whole_number())
      ->capture_default_str();
  command.add_option("--steps", options.steps, "Steps per episode (default: as the thesis has it)")
      ->check(whole_number());
  command.add_option("--alpha", options.alpha, "Learning rate (default: as the thesis has it)");
  command.add_option("--gamma", options.gamma, "Discount factor (default: as the thesis has it)");
  command.add_option("--epsilon", options.epsilon, "Exploration in the first episode (default: as the thesis has it)");
  command.add_option("--decay", options.decay, "How exploration falls over the episodes")
      ->type_name("thesis|printed|linear");
}

Result<LearnTask> learn_task(const LearnOptions& options, std::uint64_t seed) {
  Result<World> world = load_world(options.world);
  if (!world) {
    return in_context("--world", std::move(world).error());
  }
  const Result<Algorithm> algorithm = options.algorithm.empty()
                                          ? Result<Algorithm>(usual_algorithm(world->kind))
                                          : value_named<Algorithm>("algorithm", options.algorithm);
  if (!algorithm) {
    return in_context("--algorithm", algorithm.error());
  }
  LearnSettings settings = default_settings(world->kind, *algorithm);
  settings.algorithm = *algorithm;
  settings.episodes = options.episodes.value_or(settings.episodes);
  settings.greedy_episodes = options.greedy_episodes;
  settings.steps = options.steps.value_or(settings.steps);
  settings.alpha = options.alpha.value_or(settings.alpha);
  settings.gamma = options.gamma.value_or(settings.gamma);
  settings.epsilon = options.epsilon.value_or(settings.epsilon);
  if (options.decay) {
    const Result<Decay> decay = value_named<Decay>("decay", *options.decay);
    if (!decay) {
      return in_context("--decay", decay.error());
    }
    settings.decay = *decay;
  }
  settings.seed = seed;
  if (const Result<void> checked = check_settings(settings); !checked) {
    return tl::unexpected(checked.error());
  }
  return LearnTask{options.world, std::move(*world), settings};
}

Result<LearnReport> learn_shown(const LearnTask& task, const std::string& path, const StopFlag& stop,
                                const LearnCheckpoint& resumed) {
  const std::uint64_t episodes = task.settings.episodes + task.settings.greedy_episodes;
  Progress progress(stderr, progress_settings_for(stderr), "learn", "episodes", episodes);
  Result<LearnReport> report = learn_study(
      task, path, stop, [&](std::uint64_t episodes_done) { progress.update(episodes_done); }, resumed);
  if (report) {
    progress.finish(episodes, report->summary);
  }
  return report;
}

}  // namespace coppice
