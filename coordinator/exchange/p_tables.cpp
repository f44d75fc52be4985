#include "coordinator/exchange/p_tables.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/chain/chain.hpp"
#include "coordinator/exchange/line_reader.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

using Json = nlohmann::json;

constexpr int kWithin = 1;       // depth of the members of the outermost value
constexpr int kWithinTable = 2;  // of the members of those

// Carries an Error out of the parser.
struct Stop {
  Error error;
};
[[noreturn]] void stop(const std::string& message) { throw Stop{{ErrorKind::bad_input, message}}; }

struct Step {
  double probability = 0.0;
  std::uint32_t next = 0;
  double reward = 0.0;
  bool terminated = false;
};
struct Row {
  std::uint32_t state = 0;
  std::uint32_t action = 0;
  std::size_t begin = 0;
};

class TablesReader {
 public:
  // The parser's callback: takes what is complete and lets it go, so that no more than one state is in memory as JSON.
  bool take(int depth, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::key) {
      if (depth == kWithin) {
        member_ = value.get<std::string>();
      } else if (depth == kWithinTable) {
        inner_key_ = value.get<std::string>();
      }
      return true;
    }
    const bool starts = event == Json::parse_event_t::object_start || event == Json::parse_event_t::array_start;
    if (starts) {
      if (depth == 0) {
        outer_is_object_ = event == Json::parse_event_t::object_start;
      } else if (depth == kWithin) {
        inner_key_.reset();
      }
      return true;
    }
    const bool bare = !outer_is_object_ || (member_ && to_whole(*member_));
    if (bare && depth == kWithin) {
      add_state(state_of(outer_is_object_ ? member_ : std::nullopt), value);
      return false;
    }
    if (bare || depth > kWithinTable || depth == 0 || !member_) {
      return true;
    }
    if (depth == kWithinTable) {
      if (*member_ == "P") {
        add_state(state_of(inner_key_), value);
        return false;
      }
      if (*member_ == "observations") {
        add_observation(value);
        return false;
      }
      if (*member_ == "initial") {
        add_initial(value);
        return false;
      }
      return true;
    }
    take_member(value);
    return false;
  }

  TablesSource finish(std::optional<double> collision_reward) {
    if (states_ == 0) {
      stop("no tables: expected \"P\", a list of states");
    }
    name_all();
    find_ends();
    return build(collision_reward);
  }

 private:
  void take_member(const Json& value) {
    if (*member_ == "P" || *member_ == "observations" || *member_ == "initial") {
      if (!value.is_array() && !value.is_object()) {
        stop(fmt::format("\"{}\": expected a list", *member_));
      }
      return;
    }
    if (*member_ == "format") {
      if (!value.is_string() || value != "coppice-tables-1") {
        stop(fmt::format("\"format\" is {}: expected \"coppice-tables-1\"", shown(value)));
      }
      return;
    }
    if (const auto read = read_header_member(*member_, value, source_.header); !read) {
      throw Stop{read.error()};
    }
  }

  std::uint32_t state_of(const std::optional<std::string>& key) const {
    if (!key) {
      return states_;
    }
    const auto state = to_whole(*key);
    if (!state || *state != states_) {
      stop(fmt::format("state \"{}\" of P: expected {}, states in order", key->substr(0, 40), states_));
    }
    return states_;
  }

  void add_state(std::uint32_t state, const Json& actions) {
    if (states_ == kMaxStates) {
      stop(fmt::format("more than {} states", kMaxStates));
    }
    ++states_;
    if (!actions.is_array() && !actions.is_object()) {
      stop(fmt::format("P[{}]: expected a list of actions", state));
    }
    std::uint32_t action = 0;
    for (const auto& [key, row] : actions.items()) {
      if (actions.is_object() && to_whole(key) != action) {
        stop(fmt::format("P[{}]: action \"{}\": expected {}, actions in order", state, key.substr(0, 40), action));
      }
      if (action == kMaxActions) {
        stop(fmt::format("P[{}]: more than {} actions", state, kMaxActions));
      }
      add_row(state, action++, row);
    }
    actions_ = std::max(actions_, action);
  }

  void add_row(std::uint32_t state, std::uint32_t action, const Json& row) {
    if (!row.is_array()) {
      stop(fmt::format("P[{}][{}]: expected a list of [probability, next, reward, terminated]", state, action));
    }
    if (row.empty()) {
      return;
    }
    rows_.push_back({state, action, steps_.size()});
    for (const Json& entry : row) {
      const bool shaped = entry.is_array() && (entry.size() == 4 || entry.size() == 3) && entry[0].is_number() &&
                          entry[1].is_number_integer() && entry[2].is_number() &&
                          (entry.size() == 3 || entry[3].is_boolean() || entry[3].is_number_integer());
      const std::int64_t next = shaped ? entry[1].get<std::int64_t>() : -1;
      if (next < 0 || next >= static_cast<std::int64_t>(kMaxStates)) {
        stop(fmt::format("P[{}][{}]: found {}: expected [probability, next, reward, terminated]", state, action,
                         shown(entry)));
      }
      const bool terminated =
          entry.size() == 4 && (entry[3].is_boolean() ? entry[3].get<bool>() : entry[3].get<std::int64_t>() != 0);
      if (steps_.size() == kMaxTransitions) {
        stop(fmt::format("more than {} transitions", kMaxTransitions));
      }
      const Step step{entry[0].get<double>(), static_cast<std::uint32_t>(next), entry[2].get<double>(), terminated};
      if (!(step.probability >= 0.0 && step.probability <= 1.0 + kRowTolerance) || !std::isfinite(step.reward)) {
        stop(fmt::format("P[{}][{}]: probability {} and reward {}: expected 0 to 1 and a finite number", state, action,
                         step.probability, step.reward));
      }
      if (step.probability > 0.0) {
        steps_.push_back(step);
      }
    }
  }

  void add_observation(const Json& value) {
    const std::size_t before = source_.model.readings.size();
    const auto add = [&](const Json& reading) {
      const bool fits = reading.is_boolean() || reading.is_number();
      const double number =
          !fits ? std::nan("") : (reading.is_boolean() ? (reading.get<bool>() ? 1.0 : 0.0) : reading.get<double>());
      if (!std::isfinite(number)) {
        stop(fmt::format("observations[{}]: found {}: expected numbers", observations_, shown(reading)));
      }
      source_.model.readings.push_back(number);
    };
    if (value.is_array()) {
      std::for_each(value.begin(), value.end(), add);
    } else {
      add(value);
    }
    const std::size_t found = source_.model.readings.size() - before;
    width_ = observations_ == 0 ? found : width_;
    if (found == 0 || found != width_ || found > kMaxModelFeatures) {
      stop(fmt::format("observations[{}] has {} numbers: expected {}", observations_, found,
                       observations_ == 0 ? fmt::format("1 to {}", kMaxModelFeatures) : std::to_string(width_)));
    }
    ++observations_;
  }

  void add_initial(const Json& value) {
    const double probability = value.is_number() ? value.get<double>() : -1.0;
    if (!(probability >= 0.0 && probability <= 1.0 + kRowTolerance)) {
      stop(fmt::format("initial[{}]: found {}: expected a probability", initial_.size(), shown(value)));
    }
    initial_.push_back(probability);
  }

  void name_all() {
    Model& model = source_.model;
    if (observations_ == 0) {
      for (std::uint32_t state = 0; state < states_; ++state) {
        model.readings.push_back(state);
      }
      width_ = 1;
    } else if (observations_ != states_) {
      stop(fmt::format("{} observations for {} states: expected one each", observations_, states_));
    }
    SourceHeader& header = source_.header;
    if (header.features.empty()) {
      for (std::size_t f = 0; f < width_; ++f) {
        header.features.push_back(observations_ == 0 ? "state" : fmt::format("x{}", f));
      }
      header.legends.resize(width_);
    }
    if (header.features.size() != width_) {
      stop(fmt::format("{} features for observations of {} numbers", header.features.size(), width_));
    }
    model.feature_names = header.features;
    if (actions_ == 0) {
      stop("no state has an action");
    }
    if (header.actions.empty()) {
      for (std::uint32_t a = 0; a < actions_; ++a) {
        header.actions.push_back(std::to_string(a));
      }
      header.action_legends.resize(actions_);
    }
    if (header.actions.size() < actions_) {
      stop(fmt::format("{} actions are named, P has {}", header.actions.size(), actions_));
    }
    model.action_names = header.actions;
    if (!initial_.empty() && initial_.size() != states_) {
      stop(fmt::format("{} initial probabilities for {} states: expected one each", initial_.size(), states_));
    }
    for (const Step& step : steps_) {
      if (step.next >= states_) {
        stop(fmt::format("a step leads to state {}: expected below {}", step.next, states_));
      }
    }
  }

  std::size_t end_of(std::size_t row) const { return row + 1 < rows_.size() ? rows_[row + 1].begin : steps_.size(); }

  // Which states an episode passes through, and which it ends in.
  void find_ends() {
    live_.assign(states_, initial_.empty());
    std::vector<std::uint32_t> open;
    std::vector<std::size_t> first_row(states_ + 1, rows_.size());
    for (std::size_t row = rows_.size(); row-- > 0;) {
      first_row[rows_[row].state] = row;
    }
    for (std::uint32_t state = states_; state-- > 0;) {
      first_row[state] = std::min(first_row[state], first_row[state + 1]);
    }
    for (std::uint32_t state = 0; state < initial_.size(); ++state) {
      if (initial_[state] > 0.0) {
        live_[state] = true;
        open.push_back(state);
      }
    }
    ends_.assign(states_, false);
    while (!open.empty()) {  // ends: every state is opened once
      const std::uint32_t state = open.back();
      open.pop_back();
      for (std::size_t row = first_row[state]; row < first_row[state + 1]; ++row) {
        for (std::size_t i = rows_[row].begin; i < end_of(row); ++i) {
          if (!steps_[i].terminated && !live_[steps_[i].next]) {
            live_[steps_[i].next] = true;
            open.push_back(steps_[i].next);
          }
        }
      }
    }
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      for (std::size_t i = rows_[row].begin; i < end_of(row) && live_[rows_[row].state]; ++i) {
        ends_[steps_[i].next] = ends_[steps_[i].next] || steps_[i].terminated;
      }
    }
    if (initial_.empty()) {  // who starts where is not known: a state is an end if nothing but ends leads there
      live_.assign(states_, false);
      for (std::size_t row = 0; row < rows_.size(); ++row) {
        for (std::size_t i = rows_[row].begin; i < end_of(row); ++i) {
          live_[steps_[i].next] = live_[steps_[i].next] || !steps_[i].terminated;
        }
      }
      for (std::uint32_t state = 0; state < states_; ++state) {
        live_[state] = live_[state] || !ends_[state];
      }
    }
  }

  TablesSource build(std::optional<double> collision_reward) {
    Model& model = source_.model;
    std::vector<std::uint32_t> end_of_state(states_, 0);
    auto count = states_;
    for (std::uint32_t state = 0; state < states_; ++state) {
      model.source_state.push_back(state);
    }
    for (std::uint32_t state = 0; state < states_; ++state) {
      if (!ends_[state]) {
        continue;
      }
      end_of_state[state] = state;
      if (live_[state]) {
        end_of_state[state] = count++;
        model.source_state.push_back(state);
        for (std::size_t f = 0; f < width_; ++f) {
          const double reading = model.readings[state * width_ + f];
          model.readings.push_back(reading);
        }
      }
      model.terminals.push_back(end_of_state[state]);
    }
    std::sort(model.terminals.begin(), model.terminals.end());
    const std::size_t actions = model.action_names.size();
    ModelRows rows;
    std::vector<double> collision(collision_reward ? count * actions : 0, 0.0);
    std::vector<ModelTransition> transitions;
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      transitions.clear();
      double reward = 0.0;
      double sum = 0.0;
      double collided = 0.0;
      for (std::size_t i = rows_[row].begin; i < end_of(row); ++i) {
        const Step& step = steps_[i];
        transitions.push_back(
            {step.terminated ? end_of_state_or(step.next, end_of_state) : step.next, step.probability});
        reward += step.probability * step.reward;
        sum += step.probability;
        collided += collision_reward && step.reward <= *collision_reward ? step.probability : 0.0;
      }
      if (transitions.empty()) {
        continue;
      }
      if (auto ok = rows.add(rows_[row].state, rows_[row].action, reward / sum, transitions); !ok) {
        stop(fmt::format("P[{}][{}]: {}", rows_[row].state, rows_[row].action, ok.error().message));
      }
      if (collision_reward) {
        collision[rows_[row].state * actions + rows_[row].action] = std::min(collided / sum, 1.0);
      }
    }
    if (auto ok = rows.fill(count, actions, model); !ok) {
      throw Stop{ok.error()};
    }
    model.collision = std::move(collision);
    for (std::uint32_t state = 0; state < initial_.size(); ++state) {
      if (initial_[state] > 0.0) {
        model.starts.push_back({state, initial_[state]});
      }
    }
    return std::move(source_);
  }

  // Of a step whose state no episode reaches: whatever it leads to will go.
  std::uint32_t end_of_state_or(std::uint32_t state, const std::vector<std::uint32_t>& end_of_state) const {
    return ends_[state] ? end_of_state[state] : state;
  }

  TablesSource source_;
  bool outer_is_object_ = true;
  std::optional<std::string> member_;
  std::optional<std::string> inner_key_;
  std::uint32_t states_ = 0;
  std::uint32_t actions_ = 0;
  std::size_t observations_ = 0;
  std::size_t width_ = 0;
  std::vector<double> initial_;
  std::vector<Row> rows_;
  std::vector<Step> steps_;
  std::vector<bool> live_;  // [states], an episode goes on there
  std::vector<bool> ends_;  // [states], an episode ends there
};

}  // namespace

Result<TablesSource> read_p_tables(const std::string& path, std::optional<double> collision_reward) {
  if (const auto readable = first_bytes(path, 1); !readable) {
    return tl::unexpected(readable.error());
  }
  std::ifstream file(path, std::ios::binary);
  TablesReader reader;
  try {
    [[maybe_unused]] const Json rest = Json::parse(file, [&reader](int depth, Json::parse_event_t event, Json& value) {
      return reader.take(depth, event, value);
    });
    return reader.finish(collision_reward);
  } catch (const Stop& stopped) {
    return in_context(path, stopped.error);
  } catch (const Json::exception& error) {
    return bad_input(fmt::format("{}: {}", path, error.what()));
  }
}

}  // namespace coppice
