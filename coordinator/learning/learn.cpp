#include "coordinator/learning/learn.hpp"

#include <array>
#include <fmt/format.h>

#include "coordinator/learning/learning_loop.hpp"
#include "coordinator/learning/room_map.hpp"
#include "coordinator/learning/simulators.hpp"

namespace coppice {
namespace {

constexpr std::uint64_t kMaxSteps = 0xFFFFFFFF;  // in all: no count of a chain can reach 2^32

Result<void> check_share(const char* flag, double value, bool zero_allowed) {
  if (value >= 0.0 && value <= 1.0 && (zero_allowed || value > 0.0)) {
    return {};
  }
  return bad_input(
      fmt::format("{} is {}: expected {} 0 and at most 1", flag, value, zero_allowed ? "at least" : "above"));
}

template <Algorithm kAlgorithm, typename Simulator>
Result<Learned> learn_by(const Simulator& simulator, const LearnSettings& settings, const LearnProgress& progress,
                         LearnCheckpoint* checkpoint) {
  LearningLoop<Simulator, kAlgorithm> loop(simulator, settings);
  if (checkpoint != nullptr && !checkpoint->state.empty()) {
    if (auto ok = loop.restore(*checkpoint); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  Result<Learned> learned = loop.run(progress);
  if (!learned && learned.error().kind == ErrorKind::interrupted && checkpoint != nullptr) {
    *checkpoint = loop.save();
  }
  return learned;
}

}  // namespace

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
  if (kind == WorldKind::battery) {
    // A flight is 100 steps, so the fall has to be felt from far (gamma), and states that look alike have to be
    // averaged over (alpha): README.md, "A battery to charge".
    settings.steps = 300;
    settings.alpha = algorithm == Algorithm::sarsa ? 0.05 : 0.02;
    settings.gamma = algorithm == Algorithm::sarsa ? 0.98 : 0.99;
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

Result<Learned> learn(const World& world, const LearnSettings& settings, const LearnProgress& progress,
                      LearnCheckpoint* checkpoint) {
  if (auto ok = check_settings(settings); !ok) {
    return tl::unexpected(ok.error());
  }
  if (const auto checked = make_world(std::string(name_of(world.kind)), world.room); !checked) {
    return in_context("room", checked.error());
  }
  return with_simulator(world, [&](const auto& simulator) {
    return settings.algorithm == Algorithm::sarsa
               ? learn_by<Algorithm::sarsa>(simulator, settings, progress, checkpoint)
               : learn_by<Algorithm::q_learning>(simulator, settings, progress, checkpoint);
  });
}

}  // namespace coppice
