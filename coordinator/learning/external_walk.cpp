#include "coordinator/learning/external_walk.hpp"

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <utility>

#include "common/chain/random.hpp"
#include "common/tree/tick.hpp"
#include "coordinator/learning/external_simulator.hpp"

namespace coppice {
namespace {

constexpr ActionId kWhenUnknown{0};  // greedy on a row of zeros
constexpr unsigned kSeedShift = 11;  // 53 bits: a number that every JSON reader keeps

std::string features_key(std::span<const std::uint8_t> features) { return {features.begin(), features.end()}; }

// One episode under way.
struct OutsideEpisode {
  std::size_t number = 0;  // index of its record
  std::vector<double> readings;
  std::optional<std::vector<std::uint8_t>> features;  // nothing: a reading that the vocabulary does not declare
  std::optional<std::uint32_t> state;                 // nothing: the chain does not know it
};

class OutsideWalk {
 public:
  OutsideWalk(ExternalSimulator& simulator, const Chain& chain, const Tree* tree, const SimulateSettings& settings,
              const SimulateProgress& go_on, const SimulateWatch& watch)
      : simulator_(simulator),
        chain_(chain),
        tree_(tree),
        settings_(settings),
        go_on_(go_on),
        watch_(watch),
        first_features_(chain.features_of(chain.initial_state())) {
    // Of states that look alike the first one speaks for all.
    for (std::uint32_t state = 0; state < chain.states(); ++state) {
      if (!chain.is_terminal(state)) {  // there nothing is decided any more
        state_of_.emplace(features_key(chain.features_of(state)), state);
      }
    }
  }

  Result<std::vector<EpisodeRecord>> run() {
    records_.resize(settings_.episodes);
    places_.resize(std::min<std::uint64_t>(simulator_.at_once(), settings_.episodes));
    std::vector<std::uint32_t> free(places_.size());
    for (std::uint32_t place = 0; place < free.size(); ++place) {
      free[place] = place;
    }
    // Ends with the episodes: every turn begins or continues each that is under way, and each has a limit of steps.
    while (!free.empty() || !busy_.empty()) {
      if (auto ok = begin(free); !ok) {
        return tl::unexpected(ok.error());
      }
      if (busy_.empty()) {
        break;
      }
      if (auto ok = step(free); !ok) {
        return tl::unexpected(ok.error());
      }
    }
    return std::move(records_);
  }

 private:
  void observe(OutsideEpisode& episode, std::vector<double> readings) const {
    const std::vector<Feature>& features = chain_.vocabulary().features;
    episode.readings = std::move(readings);
    episode.features.emplace();
    for (std::size_t f = 0; f < features.size(); ++f) {
      const std::optional<std::uint8_t> value = features[f].value_of(episode.readings[f]);
      if (!value) {
        episode.features.reset();
        episode.state.reset();
        return;
      }
      episode.features->push_back(*value);
    }
    const auto found = state_of_.find(features_key(*episode.features));
    episode.state = found == state_of_.end() ? std::nullopt : std::optional(found->second);
  }

  Result<void> begin(std::vector<std::uint32_t>& free) {
    std::vector<std::uint32_t> places;
    std::vector<std::uint64_t> seeds;
    while (!free.empty() && begun_ < settings_.episodes) {
      if (go_on_ && !go_on_()) {
        return interrupted();
      }
      const std::uint32_t place = free.back();
      free.pop_back();
      const std::uint64_t number = settings_.first_episode + begun_;
      Stream random(settings_.seed, Purpose::simulating, static_cast<std::uint32_t>(number >> 32U),
                    static_cast<std::uint32_t>(number));
      places.push_back(place);
      seeds.push_back(random.next() >> kSeedShift);
      places_[place].number = begun_++;
    }
    if (begun_ == settings_.episodes) {
      free.clear();
    }
    if (places.empty()) {
      return {};
    }
    auto observations = simulator_.reset(places, seeds);
    if (!observations) {
      return tl::unexpected(observations.error());
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      observe(places_[places[i]], std::move((*observations)[i]));
      busy_.push_back(places[i]);
    }
    return {};
  }

  // The action that the controller takes, counted in the record; then what takes place. Nothing: the state is held.
  std::optional<ActionId> choose(const OutsideEpisode& episode) {
    EpisodeRecord& record = records_[episode.number];
    const std::optional<ActionId> expected =
        episode.state ? std::optional(chain_.policy(*episode.state)) : std::nullopt;
    const ActionId action = tree_ == nullptr ? expected.value_or(kWhenUnknown)
                                             : tick_readings(*tree_, chain_.vocabulary(), episode.readings);
    ++record.steps;
    record.unknown += expected ? 0 : 1;
    record.matches += expected && action == *expected ? 1 : 0;
    if (!episode.state) {
      const NoAction& none = chain_.parts().no_action;
      if (action != kNoAction) {
        return action;
      }
      return none.kind == NoAction::Kind::hold    ? std::nullopt
             : none.kind == NoAction::Kind::named ? std::optional(none.action)
                                                  : std::optional(kWhenUnknown);
    }
    const std::size_t taken = chain_.taken(*episode.state, action == kNoAction ? chain_.actions() : index_of(action));
    return taken < chain_.actions() ? std::optional(ActionId{static_cast<std::uint8_t>(taken)}) : std::nullopt;
  }

  Result<void> step(std::vector<std::uint32_t>& free) {
    std::vector<std::uint32_t> places;
    std::vector<ActionId> actions;
    std::vector<std::uint32_t> still_busy;
    for (const std::uint32_t place : busy_) {
      OutsideEpisode& episode = places_[place];
      const std::optional<ActionId> action = choose(episode);
      if (action) {
        places.push_back(place);
        actions.push_back(*action);
      } else if (records_[episode.number].steps < settings_.steps) {
        still_busy.push_back(place);
      } else {
        free.push_back(place);
      }
    }
    busy_ = std::move(still_busy);
    if (places.empty()) {
      return {};
    }
    auto steps = simulator_.step(places, actions);
    if (!steps) {
      return tl::unexpected(steps.error());
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      ExternalSimulator::Step& done = (*steps)[i];
      OutsideEpisode& episode = places_[places[i]];
      EpisodeRecord& record = records_[episode.number];
      record.reward += done.reward;
      record.collisions += done.collision ? 1 : 0;
      const std::optional<std::vector<std::uint8_t>> before = episode.features;
      observe(episode, std::move(done.observation));
      if (watch_ && before && episode.features) {
        // A chain that does not end episodes has them begin again.
        const bool starts_again = done.terminated && chain_.parts().terminals.empty();
        watch_({.before = *before,
                .action = actions[i],
                .reward = done.reward,
                .after = starts_again ? first_features_ : std::span<const std::uint8_t>(*episode.features),
                .ended = done.terminated,
                .collided = simulator_.tells_collisions() ? std::optional(done.collision) : std::nullopt});
      }
      const bool ended = done.terminated || done.truncated || record.steps >= settings_.steps;
      (ended ? free : busy_).push_back(places[i]);
    }
    return {};
  }

  ExternalSimulator& simulator_;
  const Chain& chain_;
  const Tree* tree_;
  const SimulateSettings& settings_;
  const SimulateProgress& go_on_;
  const SimulateWatch& watch_;
  std::span<const std::uint8_t> first_features_;
  std::unordered_map<std::string, std::uint32_t> state_of_;
  std::vector<EpisodeRecord> records_;
  std::vector<OutsideEpisode> places_;
  std::vector<std::uint32_t> busy_;
  std::uint64_t begun_ = 0;
};

}  // namespace

Result<std::vector<EpisodeRecord>> simulate_outside(ExternalSimulator& simulator, const Chain& chain, const Tree* tree,
                                                    const SimulateSettings& settings, const SimulateProgress& go_on,
                                                    const SimulateWatch& watch) {
  return OutsideWalk(simulator, chain, tree, settings, go_on, watch).run();
}

}  // namespace coppice
