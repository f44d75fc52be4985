#include "coordinator/learning/trace.hpp"

#include <algorithm>
#include <utility>

#include "common/chain/random.hpp"
#include "common/check.hpp"
#include "common/tree/tick.hpp"
#include "coordinator/learning/simulators.hpp"

namespace coppice {
namespace {

constexpr ActionId kActionInUnknownStates{0};  // as simulate_policy()

// Where the agent is, and where trash lies; the latter is looked up only when it changes.
template <typename Room>
struct RoomPlace {
  explicit RoomPlace(const Room& room) : map(room.map()) {}

  Pose pose() const {
    const RoomStart& uav = map.starts.front();
    return {.cell = static_cast<std::uint32_t>(uav.cell), .heading = static_cast<std::uint8_t>(uav.heading)};
  }
  // Takes the room as it is now; the cell where trash came, if it moved.
  std::optional<std::uint32_t> update(const Room& room) {
    const RoomMap before = std::exchange(map, room.map());
    for (std::size_t cell = 0; cell < map.cells.size(); ++cell) {
      if (map.cells[cell] == Cell::trash && before.cells[cell] != Cell::trash) {
        return static_cast<std::uint32_t>(cell);
      }
    }
    return std::nullopt;
  }

  RoomMap map;
};

struct GridPlace {
  explicit GridPlace(const WindyGrid& grid) : place(grid.place()) {}

  Pose pose() const {
    return {.cell = static_cast<std::uint32_t>(place.y * WindyGrid::kColumns + place.x), .heading = 0};
  }
  std::optional<std::uint32_t> update(const WindyGrid& grid) {
    place = grid.place();
    return std::nullopt;
  }

  WindyGrid::Place place;
};

template <typename Simulator>
auto place_of(const Simulator& simulator) {
  if constexpr (requires { simulator.map(); }) {
    return RoomPlace(simulator);
  } else {
    return GridPlace(simulator);
  }
}

// The policy's action by observation code; kActionInUnknownStates where the chain does not know it.
template <typename Simulator>
std::vector<ActionId> policy_by_code(const Chain& chain) {
  std::vector<ActionId> policy(Simulator::kCodes, kActionInUnknownStates);
  for (std::size_t state = 0; state < chain.states(); ++state) {
    policy[Simulator::code_of(chain.features_of(state))] = chain.policy(state);
  }
  return policy;
}

template <typename Simulator>
Result<std::vector<Trace>> trace_in(Simulator simulator, const Chain& chain, const Tree* tree,
                                    const SimulateSettings& settings, const SimulateProgress& go_on) {
  COPPICE_CHECK(chain.vocabulary() == Simulator::vocabulary());
  const std::vector<ActionId> policy = policy_by_code<Simulator>(chain);
  std::vector<Trace> traces;
  traces.reserve(settings.episodes);
  for (std::uint64_t episode = 0; episode < settings.episodes; ++episode) {
    if (go_on && !go_on()) {
      return interrupted();
    }
    const std::uint64_t number = settings.first_episode + episode;
    Stream random(settings.seed, Purpose::simulating, static_cast<std::uint32_t>(number >> 32U),
                  static_cast<std::uint32_t>(number));
    simulator.reset(draw_start(simulator.starts(), random));
    auto place = place_of(simulator);
    Trace trace{.episode = number, .start = place.pose(), .steps = {}};
    bool ended = false;
    while (trace.steps.size() < settings.steps && !ended) {
      TracedStep step;
      step.features.resize(chain.vocabulary().features.size());
      Simulator::features_of(simulator.code(), step.features);
      step.action = tree != nullptr ? tick(*tree, step.features) : policy[simulator.code()];
      if (step.action != kNoAction) {
        const Outcome outcome = simulator.step(static_cast<std::uint32_t>(index_of(step.action)), random);
        step.reward = outcome.reward;
        step.collided = outcome.collided;
        step.trash_moved_to = place.update(simulator);
        ended = outcome.ended;
      }
      step.after = place.pose();
      trace.steps.push_back(std::move(step));
    }
    traces.push_back(std::move(trace));
  }
  return traces;
}

}  // namespace

std::optional<Grid> grid_of(const World& world) {
  if (world.kind == WorldKind::outside) {
    return std::nullopt;
  }
  if (world.kind == WorldKind::windy) {
    constexpr auto kWidth = static_cast<std::size_t>(WindyGrid::kColumns);
    constexpr auto kHeight = static_cast<std::size_t>(WindyGrid::kRows);
    return Grid{.width = kWidth,
                .height = kHeight,
                .cells = std::vector<Cell>(kWidth * kHeight, Cell::free),
                .goal = static_cast<std::uint32_t>(WindyGrid::kGoal.y * WindyGrid::kColumns + WindyGrid::kGoal.x)};
  }
  const Result<RoomMap> map = parse_room(world.room);
  COPPICE_CHECK(map.has_value());
  return Grid{
      .width = map->width,
      .height = map->height,
      .cells = map->cells,
      .goal = map->charger.has_value() ? std::optional(static_cast<std::uint32_t>(*map->charger)) : std::nullopt,
      .has_heading = true};
}

Result<std::vector<Trace>> trace_episodes(const World& world, const Chain& chain, const Tree* tree,
                                          const SimulateSettings& settings, const SimulateProgress& go_on) {
  return with_simulator(world,
                        [&](const auto& simulator) { return trace_in(simulator, chain, tree, settings, go_on); });
}

}  // namespace coppice
