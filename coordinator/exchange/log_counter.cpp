#include "coordinator/exchange/log_counter.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fmt/format.h>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::uint64_t kMix = 0x9E3779B97F4A7C15;

tl::unexpected<Error> wrong(const LogReader& log, const std::string& what) {
  return bad_input(fmt::format("{}: {}", log.lines().where(), what));
}

}  // namespace

ReadingCodes::ReadingCodes(std::vector<double> edges) : edges_(std::move(edges)) {}

std::size_t ReadingCodes::slot_of(double reading) const {
  std::size_t slot = static_cast<std::size_t>((std::bit_cast<std::uint64_t>(reading) * kMix) >> 54U);
  while (slots_[slot] != 0 && readings_[slots_[slot] - 1U] != reading) {
    slot = (slot + 1) % kSlots;
  }
  return slot;
}

std::optional<std::uint8_t> ReadingCodes::code_of(double reading) {
  if (any_ && reading == last_) {
    return last_code_;
  }
  reading = reading == 0.0 ? 0.0 : reading;  // -0 is 0
  std::uint8_t code = 0;
  if (binned()) {
    code = static_cast<std::uint8_t>(std::lower_bound(edges_.begin(), edges_.end(), reading) - edges_.begin());
  } else {
    const std::size_t slot = slot_of(reading);
    if (slots_[slot] == 0) {
      if (readings_.size() == kMaxValues) {
        return std::nullopt;
      }
      readings_.push_back(reading);
      slots_[slot] = static_cast<std::uint16_t>(readings_.size());
    }
    code = static_cast<std::uint8_t>(slots_[slot] - 1U);
  }
  last_ = reading;
  last_code_ = code;
  any_ = true;
  return code;
}

std::uint64_t CodeTable::hash(std::span<const std::uint8_t> codes) const {
  std::uint64_t h = codes.size();
  std::size_t at = 0;
  for (; at + 8 <= codes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, codes.data() + at, 8);
    h = std::rotl((h ^ word) * kMix, 29);
  }
  std::uint64_t word = 0;
  std::memcpy(&word, codes.data() + at, codes.size() - at);
  h = (h ^ word) * kMix;
  return h ^ (h >> 32U);
}

std::uint32_t CodeTable::number_of(std::span<const std::uint8_t> codes_of_state) {
  std::size_t slot = hash(codes_of_state) & (slots_.size() - 1);
  while (slots_[slot] != 0) {
    const std::uint32_t number = slots_[slot] - 1;
    if (std::memcmp(keys_.data() + std::size_t{number} * width_, codes_of_state.data(), width_) == 0) {
      return number;
    }
    slot = (slot + 1) & (slots_.size() - 1);
  }
  slots_[slot] = static_cast<std::uint32_t>(++size_);
  keys_.insert(keys_.end(), codes_of_state.begin(), codes_of_state.end());
  if (2 * size_ > slots_.size()) {
    grow();
  }
  return static_cast<std::uint32_t>(size_ - 1);
}

void CodeTable::grow() {
  std::vector<std::uint32_t>(slots_.size() * 2, 0).swap(slots_);
  for (std::size_t number = 0; number < size_; ++number) {
    std::size_t slot = hash(codes(number)) & (slots_.size() - 1);
    while (slots_[slot] != 0) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    slots_[slot] = static_cast<std::uint32_t>(number + 1);
  }
}

LogCounter::LogCounter(const LogCounterSettings& settings)
    : settings_(settings), states_(settings.edges.size() + 1), counts_(settings.actions.size()) {
  for (const std::vector<double>& edges : settings.edges) {
    codes_.emplace_back(edges);
  }
  for (std::size_t action = 0; action < settings.actions.size(); ++action) {
    action_of_.emplace(settings.actions[action], static_cast<std::uint32_t>(action));
  }
  key_.resize(settings.edges.size() + 1);
}

bool LogCounter::encode(std::span<const double> readings, bool terminal) {
  for (std::size_t f = 0; f < readings.size(); ++f) {
    const auto code = codes_[f].code_of(readings[f]);
    if (!code) {
      obstacle_feature_ = f;
      return false;
    }
    key_[f] = *code;
  }
  key_.back() = terminal ? 1 : 0;
  return true;
}

void LogCounter::count(std::uint32_t state, std::uint32_t action, double reward, std::uint32_t next) {
  const std::size_t actions = settings_.actions.size();
  const std::size_t rows = states_.size() * actions;
  if (reward_sum_.size() < rows) {
    reward_sum_.resize(rows, 0.0);
    collisions_.resize(settings_.collision_reward ? rows : 0, 0);
  }
  const std::size_t row = state * actions + action;
  counts_.count(state, action, next);
  reward_sum_[row] += reward;
  if (settings_.collision_reward && reward <= *settings_.collision_reward) {
    ++collisions_[row];
  }
  ++steps_;
}

// The step before led to `next`; nothing: nobody knows where.
void LogCounter::settle_last(std::optional<std::uint32_t> next) {
  if (!pending_) {
    return;
  }
  if (!next && pending_->terminated) {  // it ended, and the log does not say where: where it was, as an end
    key_.assign(key_.size(), 0);
    const auto codes = states_.codes(pending_->state);
    std::copy(codes.begin(), codes.end(), key_.begin());
    key_.back() = 1;
    next = states_.number_of(key_);
  }
  if (next) {
    count(pending_->state, pending_->action, pending_->reward, *next);
  } else {
    ++unfinished_;
  }
  pending_.reset();
}

Result<LogCounter::Obstacle> LogCounter::begin_step(const LogStep& step, const LogReader& log) {
  if (!any_action_ || step.action != last_action_) {
    const auto found = action_of_.find(std::string(step.action));
    if (found == action_of_.end()) {
      obstacle_action_ = step.action;
      return Obstacle::new_action;
    }
    last_action_ = step.action;
    last_action_index_ = found->second;
    any_action_ = true;
  }
  const bool has_episodes = !step.episode.empty();
  const bool same = in_episode_ && (!has_episodes || step.episode == episode_);
  if (same && has_episodes && step.step && last_step_ && *step.step != *last_step_ + 1) {
    return wrong(log, fmt::format("episode {}: step {} comes after step {}: expected {}", step.episode, *step.step,
                                  *last_step_, *last_step_ + 1));
  }
  const bool goes_on = !expected_.empty() && std::equal(expected_.begin(), expected_.end(), step.observation.begin());
  if (same && has_episodes && !expected_.empty() && !goes_on) {
    return wrong(log, fmt::format("episode {} has a gap: its observation is not the one that the line before led to",
                                  step.episode));
  }
  if (!same && has_episodes && step.episode == episode_ && episodes_ > 0) {
    return wrong(log, fmt::format("episode {} goes on after its end", step.episode));
  }
  if (!encode(step.observation, false)) {
    return Obstacle::too_many_readings;
  }
  const std::uint32_t state = states_.number_of(key_);
  if (!same || (!has_episodes && !expected_.empty() && !goes_on)) {
    settle_last(std::nullopt);
    ++episodes_;
    ++starts_[state];
    episode_ = step.episode;
  } else {
    settle_last(state);
  }
  pending_ = Pending{state, last_action_index_, step.reward, step.terminated};
  last_step_ = step.step;
  in_episode_ = true;
  return Obstacle::none;
}

Result<LogCounter::Obstacle> LogCounter::add(const LogStep& step, const LogReader& log) {
  auto begun = begin_step(step, log);
  if (!begun || *begun != Obstacle::none) {
    return begun;
  }
  expected_.clear();
  if (!step.next.empty()) {
    if (!encode(step.next, step.terminated)) {
      return Obstacle::too_many_readings;
    }
    settle_last(states_.number_of(key_));
    if (!step.terminated && !step.truncated) {
      expected_.assign(step.next.begin(), step.next.end());
    }
  }
  if (step.terminated || step.truncated) {
    settle_last(std::nullopt);
    in_episode_ = false;
    truncated_ += step.truncated && !step.terminated ? 1 : 0;
  }
  return Obstacle::none;
}

void LogCounter::finish() { settle_last(std::nullopt); }

}  // namespace coppice
