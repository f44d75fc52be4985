#include "coordinator/commands/learn_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "coordinator/commands/whole_number.hpp"
#include "coordinator/report/counted.hpp"
#include "coordinator/report/json_line.hpp"
#include "coordinator/report/progress.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kThesisSteps = 150;  // thesis Table II
constexpr std::uint64_t kPlainLines = 10;    // of progress, when standard error is no terminal

nlohmann::ordered_json json_of(const LearnTask& task) {
  const LearnSettings& settings = task.settings;
  return {{"world", task.world_name},      {"algorithm", name_of(settings.algorithm)},
          {"episodes", settings.episodes}, {"steps", settings.steps},
          {"alpha", settings.alpha},       {"gamma", settings.gamma},
          {"epsilon", settings.epsilon},   {"decay", name_of(settings.decay)},
          {"seed", settings.seed},         {"greedy_episodes", settings.greedy_episodes}};
}

nlohmann::ordered_json json_of(const Learned& learned) {
  return {{"states", learned.chain.states()},
          {"transitions", learned.chain.transitions()},
          {"reward_last_episodes", learned.last_rewards},
          {"largest_change", learned.largest_change},
          {"last_change_episode", learned.last_change_episode},
          {"collisions", learned.collisions},
          {"last_collision_episode", learned.last_collision_episode},
          {"steps", learned.steps},
          {"seconds", learned.seconds}};
}

std::string text_of(const LearnTask& task, const Learned& learned, const std::string& path) {
  const double steps = static_cast<double>(learned.steps);
  const std::uint64_t episodes = task.settings.episodes + task.settings.greedy_episodes;
  std::string text = fmt::format("{}: {}, {}\n", path, counted(learned.chain.states(), "state"),
                                 counted(learned.chain.transitions(), "transition"));
  text += fmt::format("{} of {} by {}, seed {}: {:.1f} s, {:.1f} ns a step\n", counted(episodes, "episode"),
                      task.world_name, name_of(task.settings.algorithm), task.settings.seed, learned.seconds,
                      steps > 0.0 ? learned.seconds / steps * 1e9 : 0.0);
  text += fmt::format("reward per episode at the end: {:.1f}\n", learned.last_rewards);
  text += learned.collisions == 0 ? std::string("no collisions\n")
                                  : fmt::format("collisions: {}, the last in episode {}\n", learned.collisions,
                                                learned.last_collision_episode);
  return text;
}

}  // namespace

void add_learn_options(CLI::App& command, LearnOptions& options) {
  command.add_option("--world", options.world, "The room of the thesis, a room of yours, or the windy grid")
      ->type_name("uav|windy|FILE.room")
      ->capture_default_str();
  command.add_option("--algorithm", options.algorithm, "How to learn")
      ->type_name("q-learning|sarsa")
      ->capture_default_str();
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
  const Result<Algorithm> algorithm = algorithm_named(options.algorithm);
  if (!algorithm) {
    return tl::unexpected(algorithm.error());
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
    const Result<Decay> decay = decay_named(*options.decay);
    if (!decay) {
      return tl::unexpected(decay.error());
    }
    settings.decay = *decay;
  }
  settings.seed = seed;
  if (const Result<void> checked = check_settings(settings); !checked) {
    return tl::unexpected(checked.error());
  }
  return LearnTask{options.world, std::move(*world), settings};
}

Result<LearnReport> learn_study(const LearnTask& task, const std::string& path, const StopFlag& stop) {
  if (const Result<void> checked = Study::check_new(path); !checked) {
    return tl::unexpected(checked.error());
  }
  const std::uint64_t episodes = task.settings.episodes + task.settings.greedy_episodes;
  ProgressSettings shown = progress_settings_for(stderr);
  shown.plain_every_done = std::max<std::uint64_t>(1, episodes / kPlainLines);
  Progress progress(stderr, shown, "learn", "episodes", episodes);
  const Result<Learned> learned = learn(task.world, task.settings, [&](std::uint64_t episodes_done) {
    progress.update(episodes_done);
    return !stop.raised();
  });
  if (!learned) {
    return tl::unexpected(learned.error());
  }
  progress.finish(episodes, fmt::format("reward {:.1f}", learned->last_rewards));

  const nlohmann::ordered_json settings = json_of(task);
  const nlohmann::ordered_json outcome = json_of(*learned);
  const StudyWorld world{name_of(task.world.kind), task.world.room};
  Result<Study> study = Study::create(path, learned->chain, world, {json_line(settings), json_line(outcome)});
  if (!study) {
    return tl::unexpected(std::move(study).error());
  }
  const nlohmann::ordered_json report = {{"study", path}, {"settings", settings}, {"outcome", outcome}};
  return LearnReport{std::move(*study), text_of(task, *learned, path), json_line(report)};
}

std::uint32_t learned_steps(const Study& study) {
  const auto settings = nlohmann::json::parse(study.learning().settings, nullptr, false);
  if (!settings.is_object() || !settings.contains("steps") || !settings["steps"].is_number_unsigned()) {
    return kThesisSteps;
  }
  const auto steps = settings["steps"].get<std::uint64_t>();
  return steps <= std::numeric_limits<std::uint32_t>::max() ? static_cast<std::uint32_t>(steps) : kThesisSteps;
}

}  // namespace coppice
