#include "coordinator/trust/events.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/check.hpp"
#include "coordinator/learning/battery_room.hpp"
#include "coordinator/learning/uav_room.hpp"

namespace coppice {
namespace {

constexpr std::string_view kRoom = "uav";
constexpr std::string_view kBattery = "battery";
constexpr std::string_view kWindy = "windy";
constexpr double kWindyStep = -1.0;
constexpr double kWindyGoal = 9.0;  // windy_grid.hpp: -1 for the step and +10 for the goal
constexpr std::string_view kForm = "NAME:reward<=NUMBER or NAME:reward>=NUMBER";

}  // namespace

Result<Event> parse_event(std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::size_t op = text.find("reward", colon == std::string_view::npos ? 0 : colon);
  const auto wrong = [&] { return bad_input(fmt::format("'{}': expected {}", text, kForm)); };
  if (colon == std::string_view::npos || colon == 0 || op != colon + 1) {
    return wrong();
  }
  Event event{.name = std::string(text.substr(0, colon)), .at_most = true, .bound = 0.0};
  const std::string_view rest = text.substr(op + std::string_view("reward").size());
  if (rest.substr(0, 2) != "<=" && rest.substr(0, 2) != ">=") {
    return wrong();
  }
  event.at_most = rest.front() == '<';
  const std::string number(rest.substr(2));
  std::size_t read = 0;
  try {
    event.bound = std::stod(number, &read);
  } catch (const std::exception&) {
    return wrong();
  }
  if (read != number.size() || !std::isfinite(event.bound)) {
    return wrong();
  }
  return event;
}

std::string to_text(const Event& event) {
  return event.counted ? "counted" : fmt::format("reward{}{}", event.at_most ? "<=" : ">=", event.bound);
}

std::vector<Event> events_of_world(std::string_view kind) {
  if (kind == kRoom) {
    return {{.name = "collision", .at_most = true, .bound = UavRoom::kCollisionReward},
            {.name = "trash", .at_most = false, .bound = UavRoom::kTrashReward}};
  }
  if (kind == kBattery) {
    return {{.name = "collision", .at_most = true, .bound = 0.0, .counted = true},
            {.name = "trash", .at_most = false, .bound = UavRoom::kTrashReward}};
  }
  if (kind == kWindy) {
    return {{.name = "goal", .at_most = false, .bound = kWindyGoal}};
  }
  return {};
}

std::vector<double> rewards_of_world(std::string_view kind) {
  if (kind == kRoom || kind == kBattery) {
    std::vector<double> rewards(UavRoom::kReward.begin(), UavRoom::kReward.end());
    rewards.push_back(UavRoom::kCollisionReward);
    rewards.push_back(UavRoom::kTrashReward);
    if (kind == kBattery) {
      rewards.push_back(BatteryRoom::kFallReward);
    }
    return rewards;
  }
  return kind == kWindy ? std::vector<double>{kWindyStep, kWindyGoal} : std::vector<double>{};
}

EventPairs pairs_of(const Event& event, const Chain& chain, const std::vector<double>& world_rewards) {
  COPPICE_CHECK(!event.counted || !chain.parts().collisions.empty());
  EventPairs result;
  result.chance.assign(chain.states() * (chain.actions() + 1), 0.0);
  for (std::size_t state = 0; state < chain.states(); ++state) {
    for (std::size_t action = 0; action < chain.actions(); ++action) {
      const std::size_t row = state * chain.actions() + action;
      if (chain.tries(row) == 0) {
        continue;
      }
      if (event.counted) {
        const double share = chain.collision_share(row);
        result.chance[state * (chain.actions() + 1) + action] = share;
        result.pairs += share > 0.0 ? 1U : 0U;
        continue;
      }
      const double mean = chain.mean_reward(row);
      const bool is_event = event.at_most ? mean <= event.bound : mean >= event.bound;
      result.chance[state * (chain.actions() + 1) + action] = is_event ? 1.0 : 0.0;
      result.pairs += is_event ? 1U : 0U;
      const bool known =
          world_rewards.empty() || std::find(world_rewards.begin(), world_rewards.end(), mean) != world_rewards.end();
      result.unclear += known ? 0U : 1U;
    }
  }
  return result;
}

}  // namespace coppice
