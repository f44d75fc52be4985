// Counts the steps of a log into a chain's rows: observations become states in the order of first sight, each pair's
// successors and rewards are summed. Values of features get codes as they come; which bins there are is settled before.
// One thread; memory grows with the distinct states and transitions, not with the log.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "common/error.hpp"
#include "coordinator/exchange/log_reader.hpp"
#include "coordinator/exchange/transition_counts.hpp"

namespace coppice {

// Readings of one feature to codes: bins by their edges, or each distinct reading one, in the order of first sight.
class ReadingCodes {
 public:
  explicit ReadingCodes(std::vector<double> edges);  // empty: no bins
  // Nothing: more than kMaxValues distinct readings.
  std::optional<std::uint8_t> code_of(double reading);
  bool binned() const { return !edges_.empty(); }
  const std::vector<double>& readings() const { return readings_; }  // by code; empty with bins
  const std::vector<double>& edges() const { return edges_; }

 private:
  static constexpr std::size_t kSlots = 1024;  // four times what they hold
  std::size_t slot_of(double reading) const;

  std::vector<double> edges_;
  std::vector<double> readings_;
  std::array<std::uint16_t, kSlots> slots_{};  // code + 1; 0: free
  double last_ = 0.0;
  std::uint8_t last_code_ = 0;
  bool any_ = false;
};

// Vectors of codes to numbers, in the order of first sight.
class CodeTable {
 public:
  explicit CodeTable(std::size_t width) : width_(width), slots_(kFirstSlots, 0) {}
  std::uint32_t number_of(std::span<const std::uint8_t> codes);
  std::size_t size() const { return size_; }
  std::span<const std::uint8_t> codes(std::size_t number) const {
    return std::span<const std::uint8_t>(keys_).subspan(number * width_, width_);
  }
  // What is needed no more once all are known.
  void forget_index() { std::vector<std::uint32_t>().swap(slots_); }

 private:
  static constexpr std::size_t kFirstSlots = std::size_t{1} << 12U;
  std::uint64_t hash(std::span<const std::uint8_t> codes) const;
  void grow();

  std::size_t width_;
  std::size_t size_ = 0;
  std::vector<std::uint8_t> keys_;    // [numbers x width]
  std::vector<std::uint32_t> slots_;  // number + 1; 0: free
};

struct LogCounterSettings {
  std::vector<std::vector<double>> edges;  // [features], empty where there are no bins
  std::vector<std::string> actions;
  std::optional<double> collision_reward;
};

class LogCounter {
 public:
  // What cannot be counted with these settings: the pass has to begin again with better ones.
  enum class Obstacle : std::uint8_t { none, new_action, too_many_readings };

  explicit LogCounter(const LogCounterSettings& settings);

  // Errors name the line: a gap in an episode, one that goes on after its end.
  Result<Obstacle> add(const LogStep& step, const LogReader& log);
  // After the last line. Errors: as add().
  void finish();

  const std::string& obstacle_action() const { return obstacle_action_; }
  std::size_t obstacle_feature() const { return obstacle_feature_; }

  std::vector<ReadingCodes>& codes() { return codes_; }
  // Codes of the features, and one that is 1 for a state that ends episodes.
  CodeTable& states() { return states_; }
  TransitionCounts& counts() { return counts_; }
  std::vector<double> take_reward_sum() { return std::move(reward_sum_); }         // [states x actions, more or less]
  std::vector<std::uint32_t> take_collisions() { return std::move(collisions_); }  // the same, or empty
  const std::unordered_map<std::uint32_t, std::uint64_t>& starts() const { return starts_; }
  std::uint64_t steps() const { return steps_; }            // counted
  std::uint64_t unfinished() const { return unfinished_; }  // steps whose successor the log does not have
  std::uint64_t episodes() const { return episodes_; }
  std::uint64_t truncated() const { return truncated_; }

 private:
  Result<Obstacle> begin_step(const LogStep& step, const LogReader& log);
  bool encode(std::span<const double> readings, bool terminal);
  void count(std::uint32_t state, std::uint32_t action, double reward, std::uint32_t next);
  void settle_last(std::optional<std::uint32_t> next);

  LogCounterSettings settings_;
  std::vector<ReadingCodes> codes_;
  CodeTable states_;
  TransitionCounts counts_;
  std::unordered_map<std::string, std::uint32_t> action_of_;
  std::string last_action_;
  std::uint32_t last_action_index_ = 0;
  bool any_action_ = false;
  std::vector<double> reward_sum_;
  std::vector<std::uint32_t> collisions_;
  std::unordered_map<std::uint32_t, std::uint64_t> starts_;
  std::vector<std::uint8_t> key_;
  // The step before, while its successor is not known.
  struct Pending {
    std::uint32_t state = 0;
    std::uint32_t action = 0;
    double reward = 0.0;
    bool terminated = false;
  };
  std::optional<Pending> pending_;
  // The episode under way.
  bool in_episode_ = false;
  std::string episode_;
  std::optional<std::uint64_t> last_step_;
  std::vector<double> expected_;  // the observation that has to come next; empty: not known
  std::string obstacle_action_;
  std::size_t obstacle_feature_ = 0;
  std::uint64_t steps_ = 0;
  std::uint64_t unfinished_ = 0;
  std::uint64_t episodes_ = 0;
  std::uint64_t truncated_ = 0;
};

}  // namespace coppice
