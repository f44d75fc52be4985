#include "coordinator/studio/page_world.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/chain/random.hpp"
#include "coordinator/learning/trace.hpp"
#include "coordinator/report/on_chain.hpp"
#include "coordinator/studio/page_numbers.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kBefore = 4;  // steps of a motion that are shown before what it is about
constexpr std::uint32_t kAfter = 8;
constexpr std::uint32_t kSoon = 4;  // steps within which trash that was seen must be collected
constexpr double kTrash = 20.0;     // reward of collecting it, uav_room.hpp

std::string cells_text(const std::vector<Cell>& cells) {
  constexpr std::array<char, 3> kSigns{'#', '.', '*'};
  std::string text;
  for (const Cell cell : cells) {
    text += kSigns[static_cast<std::size_t>(cell)];
  }
  return text;
}

// Some steps of a trace, with where everything lies when they begin.
struct Scene {
  Pose pose{};
  std::vector<std::uint32_t> trash;
  std::size_t first = 0;
  std::size_t steps = 0;
};

Scene scene_of(const Trace& trace, const Grid& grid, std::size_t first, std::size_t end) {
  std::vector<bool> trash;
  trash.reserve(grid.cells.size());
  for (const Cell cell : grid.cells) {
    trash.push_back(cell == Cell::trash);
  }
  Scene scene{.pose = trace.start, .trash = {}, .first = first, .steps = std::min(end, trace.steps.size()) - first};
  for (std::size_t i = 0; i < first; ++i) {
    const TracedStep& step = trace.steps[i];
    scene.pose = step.after;
    if (step.trash_moved_to) {
      trash[step.after.cell] = false;
      trash[*step.trash_moved_to] = true;
    }
  }
  for (std::uint32_t cell = 0; cell < trash.size(); ++cell) {
    if (trash[cell]) {
      scene.trash.push_back(cell);
    }
  }
  return scene;
}

Json json_of(const Trace& trace, const Scene& scene, const std::string& who, const std::string& title) {
  Json steps = Json::array();
  for (std::size_t i = scene.first; i < scene.first + scene.steps; ++i) {
    const TracedStep& step = trace.steps[i];
    steps.push_back({step.action == kNoAction ? Json(-1) : Json(index_of(step.action)), step.after.cell,
                     step.after.heading, page_number(step.reward), step.collided ? 1 : 0,
                     step.trash_moved_to ? Json(*step.trash_moved_to) : Json(-1), Json(step.features)});
  }
  return {{"who", who},
          {"title", title},
          {"episode", trace.episode},
          {"first_step", scene.first},
          {"cell", scene.pose.cell},
          {"heading", scene.pose.heading},
          {"trash", scene.trash},
          {"steps", steps}};
}

// The sensors of a room by name, as the thesis numbers them (Figure 7).
struct Sensors {
  std::size_t left = 0;
  std::size_t ahead = 0;
  std::size_t right = 0;
};

std::optional<Sensors> sensors_of(const Vocabulary& vocabulary) {
  const auto left = vocabulary.find_feature("s1");
  const auto ahead = vocabulary.find_feature("s3");
  const auto right = vocabulary.find_feature("s5");
  if (!left || !ahead || !right) {
    return std::nullopt;
  }
  return Sensors{.left = *left, .ahead = *ahead, .right = *right};
}

struct Motion {
  std::string title;
  // Whether it begins with step i of the trace.
  std::function<bool(const Trace&, std::size_t i)> begins;
};

std::vector<Motion> motions_of(const Sensors& sensors) {
  constexpr std::uint8_t kWall = 0;
  constexpr std::uint8_t kSeenTrash = 3;
  const auto reads = [](const Trace& trace, std::size_t i, std::size_t feature, std::uint8_t value) {
    return trace.steps[i].features[feature] == value;
  };
  const auto collected_soon = [](const Trace& trace, std::size_t i) {
    const std::size_t end = std::min<std::size_t>(i + kSoon, trace.steps.size());
    return std::any_of(trace.steps.begin() + static_cast<std::ptrdiff_t>(i),
                       trace.steps.begin() + static_cast<std::ptrdiff_t>(end),
                       [](const TracedStep& step) { return step.reward == kTrash; });
  };
  return {{"trash on its right, collected",
           [=](const Trace& trace, std::size_t i) {
             return reads(trace, i, sensors.right, kSeenTrash) && !reads(trace, i, sensors.ahead, kSeenTrash) &&
                    collected_soon(trace, i);
           }},
          {"trash on its right",
           [=](const Trace& trace, std::size_t i) {
             return reads(trace, i, sensors.right, kSeenTrash) && !reads(trace, i, sensors.ahead, kSeenTrash);
           }},
          {"a corner",
           [=](const Trace& trace, std::size_t i) {
             return reads(trace, i, sensors.ahead, kWall) &&
                    (reads(trace, i, sensors.left, kWall) || reads(trace, i, sensors.right, kWall));
           }},
          {"a wall ahead",
           [=](const Trace& trace, std::size_t i) {
             return reads(trace, i, sensors.ahead, kWall) && !reads(trace, i, sensors.left, kWall) &&
                    !reads(trace, i, sensors.right, kWall);
           }},
          {"a collision", [](const Trace& trace, std::size_t i) { return trace.steps[i].collided; }}};
}

void add_motions(const std::vector<Trace>& traces, const Grid& grid, const Sensors& sensors, const std::string& who,
                 Json& replays) {
  bool trash_collected = false;
  for (const Motion& motion : motions_of(sensors)) {
    if (motion.title == "trash on its right" && trash_collected) {
      continue;  // the better example of it is there
    }
    for (const Trace& trace : traces) {
      std::size_t i = 0;
      while (i < trace.steps.size() && !motion.begins(trace, i)) {
        ++i;
      }
      if (i < trace.steps.size()) {
        const std::size_t first = i < kBefore ? 0 : i - kBefore;
        replays.push_back(json_of(trace, scene_of(trace, grid, first, i + kAfter), who, motion.title));
        trash_collected = trash_collected || motion.title == "trash on its right, collected";
        break;
      }
    }
  }
}

// Steps that ended in each cell, all episodes together; where it stood at the start of an episode counts once.
std::vector<std::uint64_t> visits_by_cell(const std::vector<Trace>& traces, const Grid& grid) {
  std::vector<std::uint64_t> visits(grid.cells.size(), 0);
  for (const Trace& trace : traces) {
    ++visits[trace.start.cell];
    for (const TracedStep& step : trace.steps) {
      ++visits[step.after.cell];
    }
  }
  return visits;
}

// As many of the episodes as kMostTracedCells allows, one at least.
SimulateSettings bounded(SimulateSettings settings, const Grid& grid) {
  const std::uint64_t cells = std::max<std::uint64_t>(std::uint64_t{grid.cells.size()} * settings.steps, 1);
  settings.episodes = std::max<std::uint64_t>(std::min(settings.episodes, kMostTracedCells / cells), 1);
  return settings;
}

std::uint32_t start_of(const Chain& chain, Stream& random) {
  std::uint64_t unit = random.below(chain.starts_total());
  std::size_t i = 0;
  while (unit >= chain.starts()[i].count) {
    unit -= chain.starts()[i].count;
    ++i;
  }
  return chain.starts()[i].state;
}

// taken: as Chain::taken().
std::uint32_t successor(const Chain& chain, std::uint32_t state, std::size_t taken, Stream& random) {
  if (taken == chain.actions()) {
    return state;
  }
  const std::size_t row = state * chain.actions() + taken;
  if (chain.tries(row) == 0) {
    return static_cast<std::uint32_t>(random.below(chain.states()));
  }
  std::uint64_t unit = random.below(chain.tries(row));
  const auto counts = chain.counts(row);
  std::size_t i = 0;
  while (unit >= counts[i]) {
    unit -= counts[i];
    ++i;
  }
  return chain.successors(row)[i];
}

Json walk_json(const Chain& chain, const ChainActions& actions, std::uint32_t steps, std::uint64_t seed,
               const std::string& who) {
  Stream random(seed, Purpose::rollout, 0, 0);
  Json list = Json::array();
  std::uint32_t state = start_of(chain, random);
  for (std::uint32_t i = 0; i < steps && !chain.is_terminal(state); ++i) {
    const std::size_t taken = chain.taken(state, actions[state]);
    const double reward = taken == chain.actions() ? 0.0 : chain.mean_reward(state * chain.actions() + taken);
    list.push_back({actions[state] < chain.actions() ? Json(actions[state]) : Json(-1), state, page_number(reward),
                    index_of(chain.policy(state)),
                    Json(std::vector<std::uint8_t>(chain.features_of(state).begin(), chain.features_of(state).end()))});
    state = successor(chain, state, taken, random);
  }
  return {{"who", who}, {"title", "a walk through the chain"}, {"seed", seed}, {"steps", list}};
}

}  // namespace

Result<Json> world_json(const World& world, const Chain& chain, const Tree& tree, const SimulateSettings& settings,
                        const SimulateProgress& go_on) {
  const std::optional<Grid> grid = grid_of(world);
  if (!grid) {
    return Json(nullptr);
  }
  const SimulateSettings traced = bounded(settings, *grid);
  const auto by_tree = trace_episodes(world, chain, &tree, traced, go_on);
  if (!by_tree) {
    return tl::unexpected(by_tree.error());
  }
  const auto by_policy = trace_episodes(world, chain, nullptr, traced, go_on);
  if (!by_policy) {
    return tl::unexpected(by_policy.error());
  }
  Json replays = Json::array();
  for (const auto& [who, traces] : {std::pair("tree", &*by_tree), std::pair("policy", &*by_policy)}) {
    const Trace& first = traces->front();
    replays.push_back(json_of(first, scene_of(first, *grid, 0, first.steps.size()), who, "a whole episode"));
    if (const auto sensors = sensors_of(chain.vocabulary())) {
      add_motions(*traces, *grid, *sensors, who, replays);
    }
  }
  Json json = {{"kind", name_of(world.kind)},      {"width", grid->width},
               {"height", grid->height},           {"cells", cells_text(grid->cells)},
               {"has_heading", grid->has_heading}, {"goal", grid->goal ? Json(*grid->goal) : Json(nullptr)}};
  json["maps"] = {{"episodes", traced.episodes},
                  {"steps", traced.steps},
                  {"seed", traced.seed},
                  {"tree", visits_by_cell(*by_tree, *grid)},
                  {"policy", visits_by_cell(*by_policy, *grid)}};
  json["replays"] = replays;
  return json;
}

Result<Json> replay_to(const World& world, const Chain& chain, const Tree& tree, const SimulateSettings& settings,
                       const std::vector<std::uint8_t>& features, const SimulateProgress& go_on) {
  const std::optional<Grid> grid = grid_of(world);
  if (!grid) {
    return Json(nullptr);
  }
  SimulateSettings one = bounded(settings, *grid);
  const std::uint64_t episodes = one.episodes;
  one.episodes = 1;
  for (std::uint64_t episode = 0; episode < episodes; ++episode) {
    one.first_episode = settings.first_episode + episode;
    const auto traces = trace_episodes(world, chain, &tree, one, go_on);
    if (!traces) {
      return tl::unexpected(traces.error());
    }
    const Trace& trace = traces->front();
    const auto found = std::find_if(trace.steps.begin(), trace.steps.end(),
                                    [&](const TracedStep& step) { return step.features == features; });
    if (found != trace.steps.end()) {
      const auto at = static_cast<std::size_t>(found - trace.steps.begin());
      const std::size_t first = at < kBefore ? 0 : at - kBefore;
      Json replay = json_of(trace, scene_of(trace, *grid, first, at + kAfter), "tree", "a walk that comes there");
      replay["at"] = at - first;
      return replay;
    }
  }
  return Json(nullptr);
}

Json walks_json(const Chain& chain, const Tree& tree, std::uint32_t steps, std::uint64_t seed) {
  constexpr std::uint32_t kMostWalkSteps = 200;
  const std::uint32_t shown = std::min(steps, kMostWalkSteps);
  return Json::array({walk_json(chain, actions_of(chain, tree), shown, seed, "tree"),
                      walk_json(chain, actions_of_policy(chain), shown, seed, "policy")});
}

}  // namespace coppice
