#include "coordinator/runs/learn_study.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/runs/interrupted_learning.hpp"

namespace coppice {
namespace {

constexpr std::uint32_t kThesisSteps = 150;  // thesis Table II

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
          {"seconds", learned.seconds},
          {"curve",
           {{"episodes_per_point", learned.curve.episodes_per_point},
            {"reward", learned.curve.reward},
            {"collisions", learned.curve.collisions}}}};
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

Result<LearnReport> learn_study(const LearnTask& task, const std::string& path, const StopFlag& stop,
                                const std::function<void(std::uint64_t)>& episodes_done,
                                const LearnCheckpoint& resumed) {
  if (const Result<void> checked = Study::check_new(path); !checked) {
    return tl::unexpected(checked.error());
  }
  const std::filesystem::path interrupted = interrupted_learning_path(path);
  std::error_code ignored;
  if (resumed.state.empty() && std::filesystem::exists(interrupted, ignored)) {
    return bad_input(fmt::format("{}: learning was interrupted here: expected --resume, or that you delete this file",
                                 interrupted.string()));
  }
  LearnCheckpoint checkpoint = resumed;
  const Result<Learned> learned = learn(
      task.world, task.settings,
      [&](std::uint64_t done) {
        episodes_done(done);
        return !stop.raised();
      },
      &checkpoint);
  if (!learned) {
    if (learned.error().kind == ErrorKind::interrupted) {
      if (const Result<void> kept = write_interrupted_learning(interrupted, {task, checkpoint}); !kept) {
        return tl::unexpected(kept.error());
      }
      return tl::unexpected(
          Error{ErrorKind::interrupted,
                fmt::format("interrupted after {} of {} episodes; go on with: coppice learn -o {} --resume",
                            checkpoint.episodes_done, task.settings.episodes + task.settings.greedy_episodes, path)});
    }
    return tl::unexpected(learned.error());
  }
  const nlohmann::ordered_json settings = json_of(task);
  const nlohmann::ordered_json outcome = json_of(*learned);
  const StudyWorld world{std::string(name_of(task.world.kind)), task.world.room};
  Result<Study> study = Study::create(path, learned->chain, world, {json_line(settings), json_line(outcome)});
  if (!study) {
    return tl::unexpected(std::move(study).error());
  }
  if (!resumed.state.empty()) {
    std::filesystem::remove(interrupted, ignored);
  }
  const nlohmann::ordered_json report = {{"study", path}, {"settings", settings}, {"outcome", outcome}};
  return LearnReport{std::move(*study), fmt::format("reward {:.1f}", learned->last_rewards),
                     text_of(task, *learned, path), json_line(report)};
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
