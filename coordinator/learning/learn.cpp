#include "coordinator/learning/learn.hpp"

#include <array>
#include <fmt/format.h>

#include "coordinator/learning/learning_loop.hpp"
#include "coordinator/learning/room_map.hpp"
#include "coordinator/learning/uav_room.hpp"
#include "coordinator/learning/windy_grid.hpp"

namespace coppice {
namespace {

constexpr std::array kAlgorithms{Algorithm::q_learning, Algorithm::sarsa};
constexpr std::array kDecays{Decay::thesis, Decay::printed, Decay::linear};
constexpr std::uint64_t kMaxSteps = 0xFFFFFFFF;  // in all: no count of a chain can reach 2^32

Result<void> check_share(const char* flag, double value, bool zero_allowed) {
  if (value >= 0.0 && value <= 1.0 && (zero_allowed || value > 0.0)) {
    return {};
  }
  return bad_input(
      fmt::format("{} is {}: expected {} 0 and at most 1", flag, value, zero_allowed ? "at least" : "above"));
}

template <typename Simulator>
Result<Learned> learn_in(Simulator simulator, const LearnSettings& settings, const LearnProgress& progress) {
  if (settings.algorithm == Algorithm::sarsa) {
    return LearningLoop<Simulator, Algorithm::sarsa>(std::move(simulator), settings).run(progress);
  }
  return LearningLoop<Simulator, Algorithm::q_learning>(std::move(simulator), settings).run(progress);
}

}  // namespace

std::string_view name_of(Algorithm algorithm) { return algorithm == Algorithm::sarsa ? "sarsa" : "q-learning"; }

std::string_view name_of(Decay decay) {
  switch (decay) {
    case Decay::printed:
      return "printed";
    case Decay::linear:
      return "linear";
    case Decay::thesis:
      break;
  }
  return "thesis";
}

Result<Algorithm> algorithm_named(std::string_view name) {
  for (const Algorithm algorithm : kAlgorithms) {
    if (name == name_of(algorithm)) {
      return algorithm;
    }
  }
  return bad_input(fmt::format("--algorithm is '{}': expected q-learning or sarsa", name));
}

Result<Decay> decay_named(std::string_view name) {
  for (const Decay decay : kDecays) {
    if (name == name_of(decay)) {
      return decay;
    }
  }
  return bad_input(fmt::format("--decay is '{}': expected thesis, printed or linear", name));
}

LearnSettings default_settings(WorldKind kind, Algorithm algorithm) {
  LearnSettings settings;
  settings.algorithm = algorithm;
  if (kind == WorldKind::windy) {
    settings.episodes = 2000;
    settings.steps = 25;
    settings.alpha = 0.3;
    settings.gamma = algorithm == Algorithm::sarsa ? 0.9 : 0.8;
    settings.decay = Decay::linear;
  }
  return settings;
}

Result<void> check_settings(const LearnSettings& settings) {
  if (settings.episodes == 0 || settings.episodes > kMaxSteps) {
    return bad_input(fmt::format("--episodes is {}: expected 1 to {}", settings.episodes, kMaxSteps));
  }
  if (settings.steps == 0 || settings.steps > kMaxEpisodeSteps) {
    return bad_input(fmt::format("--steps is {}: expected 1 to {}", settings.steps, kMaxEpisodeSteps));
  }
  if (settings.greedy_episodes > kMaxSteps - settings.episodes) {
    return bad_input(fmt::format("--greedy-episodes is {}: expected at most {}", settings.greedy_episodes,
                                 kMaxSteps - settings.episodes));
  }
  if (settings.steps > kMaxSteps / (settings.episodes + settings.greedy_episodes)) {
    return bad_input(fmt::format("--steps is {}: expected --episodes ({}) times --steps to be at most {}",
                                 settings.steps, settings.episodes, kMaxSteps));
  }
  if (auto ok = check_share("--alpha", settings.alpha, false); !ok) {
    return ok;
  }
  if (auto ok = check_share("--gamma", settings.gamma, true); !ok) {
    return ok;
  }
  return check_share("--epsilon", settings.epsilon, true);
}

double exploration(const LearnSettings& settings, std::uint64_t episode) {
  if (episode > settings.episodes) {
    return 0.0;
  }
  const auto episodes = static_cast<double>(settings.episodes);
  const auto e = static_cast<double>(episode);
  const double nd = episodes / 100.0;
  switch (settings.decay) {
    case Decay::printed:
      return std::min(1.0, settings.epsilon * (nd + 1.0) / (nd * e));
    case Decay::linear:
      return settings.episodes == 1 ? 0.0 : settings.epsilon * (episodes - e) / (episodes - 1.0);
    case Decay::thesis:
      break;
  }
  return settings.epsilon * (nd + 1.0) / (nd + e);
}

Result<Learned> learn(const World& world, const LearnSettings& settings, const LearnProgress& progress) {
  if (auto ok = check_settings(settings); !ok) {
    return tl::unexpected(ok.error());
  }
  if (world.kind == WorldKind::windy) {
    return learn_in(WindyGrid(), settings, progress);
  }
  const auto map = parse_room(world.room);
  if (!map) {
    return in_context("room", map.error());
  }
  return learn_in(UavRoom(*map), settings, progress);
}

}  // namespace coppice
