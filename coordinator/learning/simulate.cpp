#include "coordinator/learning/simulate.hpp"

#include <optional>
#include <span>
#include <utility>

#include "common/chain/random.hpp"
#include "common/check.hpp"
#include "common/tree/tick.hpp"
#include "coordinator/learning/external_walk.hpp"
#include "coordinator/learning/simulators.hpp"

namespace coppice {
namespace {

constexpr ActionId kActionWhenUnknown{0};  // greedy on a row of zeros

// What the simulator shows, seen from the chain: per observation code its features and the policy's action there.
template <typename Simulator>
class Observations {
 public:
  explicit Observations(const Chain& chain)
      : width_(chain.vocabulary().features.size()), features_(Simulator::kCodes * width_), policy_(Simulator::kCodes) {
    COPPICE_CHECK(chain.vocabulary() == Simulator::vocabulary());
    for (std::uint32_t code = 0; code < Simulator::kCodes; ++code) {
      Simulator::features_of(code, std::span(features_).subspan(code * width_, width_));
    }
    for (std::size_t state = 0; state < chain.states(); ++state) {
      policy_[Simulator::code_of(chain.features_of(state))] = chain.policy(state);
    }
  }

  std::span<const std::uint8_t> features(std::uint32_t code) const {
    return std::span(features_).subspan(code * width_, width_);
  }
  // Nothing where the chain does not know the state.
  std::optional<ActionId> policy(std::uint32_t code) const { return policy_[code]; }

 private:
  std::size_t width_;
  std::vector<std::uint8_t> features_;           // [codes x features]
  std::vector<std::optional<ActionId>> policy_;  // [codes]
};

// Controller: (code) -> the action that it takes, or kNoAction.
template <typename Simulator, typename Controller>
Result<std::vector<EpisodeRecord>> run_episodes(Simulator simulator, const Observations<Simulator>& observations,
                                                const SimulateSettings& settings, const SimulateProgress& go_on,
                                                const SimulateWatch& watch, const Controller& controller) {
  std::vector<EpisodeRecord> records;
  records.reserve(settings.episodes);
  for (std::uint64_t episode = 0; episode < settings.episodes; ++episode) {
    if (go_on && !go_on()) {
      return interrupted();
    }
    const std::uint64_t number = settings.first_episode + episode;
    Stream random(settings.seed, Purpose::simulating, static_cast<std::uint32_t>(number >> 32U),
                  static_cast<std::uint32_t>(number));
    EpisodeRecord record;
    simulator.reset(draw_start(simulator.starts(), random));
    bool ended = false;
    while (record.steps < settings.steps && !ended) {
      const std::uint32_t code = simulator.code();
      const ActionId action = controller(code);
      const std::optional<ActionId> expected = observations.policy(code);
      ++record.steps;
      record.unknown += expected ? 0 : 1;
      record.matches += expected && action == *expected ? 1 : 0;
      if (action == kNoAction) {
        continue;
      }
      const Outcome outcome = simulator.step(static_cast<std::uint32_t>(index_of(action)), random);
      record.reward += outcome.reward;
      record.collisions += outcome.collided ? 1 : 0;
      ended = outcome.ended;
      if (watch) {
        if (ended) {
          simulator.reset(draw_start(simulator.starts(), random));
        }
        watch({.before = observations.features(code),
               .action = action,
               .reward = outcome.reward,
               .after = observations.features(simulator.code()),
               .collided = outcome.collided});
      }
    }
    records.push_back(record);
  }
  return records;
}

// tree: nullptr for the policy itself.
template <typename Simulator>
Result<std::vector<EpisodeRecord>> simulate_in(const Simulator& simulator, const Chain& chain, const Tree* tree,
                                               const SimulateSettings& settings, const SimulateProgress& go_on,
                                               const SimulateWatch& watch) {
  const Observations<Simulator> observations(chain);
  if (tree != nullptr) {
    COPPICE_CHECK(check_tree(*tree, chain.vocabulary()).has_value());
    return run_episodes(simulator, observations, settings, go_on, watch,
                        [&](std::uint32_t code) { return tick(*tree, observations.features(code)); });
  }
  return run_episodes(simulator, observations, settings, go_on, watch,
                      [&](std::uint32_t code) { return observations.policy(code).value_or(kActionWhenUnknown); });
}

// The process of a problem's own simulator; nothing for a world of ours.
Result<std::optional<ExternalSimulator>> start_outside(const World& world, const Chain& chain,
                                                       const SimulateSettings& settings) {
  if (world.kind != WorldKind::outside) {
    return std::nullopt;
  }
  return ExternalSimulator::start(world.simulator, chain.vocabulary(), settings.stop)
      .map([](ExternalSimulator started) { return std::optional(std::move(started)); });
}

// In `outside`, if there is one.
Result<std::vector<EpisodeRecord>> simulate(std::optional<ExternalSimulator>& outside, const World& world,
                                            const Chain& chain, const Tree* tree, const SimulateSettings& settings,
                                            const SimulateProgress& go_on, const SimulateWatch& watch) {
  if (outside) {
    return simulate_outside(*outside, chain, tree, settings, go_on, watch);
  }
  return with_simulator(
      world, [&](const auto& simulator) { return simulate_in(simulator, chain, tree, settings, go_on, watch); });
}

}  // namespace

Result<std::vector<EpisodeRecord>> simulate_tree(const World& world, const Chain& chain, const Tree& tree,
                                                 const SimulateSettings& settings, const SimulateProgress& go_on,
                                                 const SimulateWatch& watch) {
  auto outside = start_outside(world, chain, settings);
  if (!outside) {
    return tl::unexpected(std::move(outside).error());
  }
  return simulate(*outside, world, chain, &tree, settings, go_on, watch);
}

Result<std::vector<std::vector<EpisodeRecord>>> simulate_trees(const World& world, const Chain& chain,
                                                               std::span<const Tree> trees,
                                                               const SimulateSettings& settings,
                                                               const SimulateProgress& go_on,
                                                               const std::function<void(std::size_t)>& done) {
  auto outside = start_outside(world, chain, settings);
  if (!outside) {
    return tl::unexpected(std::move(outside).error());
  }
  std::vector<std::vector<EpisodeRecord>> all;
  for (const Tree& tree : trees) {
    auto episodes = simulate(*outside, world, chain, &tree, settings, go_on, {});
    if (!episodes) {
      return tl::unexpected(std::move(episodes).error());
    }
    all.push_back(*std::move(episodes));
    if (done) {
      done(all.size());
    }
  }
  return all;
}

Result<std::vector<EpisodeRecord>> simulate_policy(const World& world, const Chain& chain,
                                                   const SimulateSettings& settings, const SimulateProgress& go_on) {
  auto outside = start_outside(world, chain, settings);
  if (!outside) {
    return tl::unexpected(std::move(outside).error());
  }
  return simulate(*outside, world, chain, nullptr, settings, go_on, {});
}

}  // namespace coppice
