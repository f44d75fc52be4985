#include "coordinator/exchange/drn.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <unordered_map>

#include "common/chain/chain.hpp"
#include "coordinator/exchange/line_reader.hpp"
#include "coordinator/exchange/reward_choice.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

constexpr std::size_t kQuoted = 40;  // characters of a line repeated in a message

std::string quoted(std::string_view text) {
  return fmt::format("'{}{}'", text.substr(0, kQuoted), text.size() > kQuoted ? "..." : "");
}

struct Valuation {
  std::string name;
  double value = 0.0;
};

// "x=0", "!picked", "picked".
std::optional<Valuation> valuation_of(std::string_view text) {
  text = trimmed(text);
  if (text.empty()) {
    return std::nullopt;
  }
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    const bool negated = text.front() == '!';
    return Valuation{std::string(trimmed(text.substr(negated ? 1 : 0))), negated ? 0.0 : 1.0};
  }
  const std::string_view value = trimmed(text.substr(equals + 1));
  const std::string_view name = trimmed(text.substr(0, equals));
  if (value == "true" || value == "false") {
    return Valuation{std::string(name), value == "true" ? 1.0 : 0.0};
  }
  const auto number = to_fraction(value);
  return number && std::isfinite(*number) && !name.empty() ? std::optional(Valuation{std::string(name), *number})
                                                           : std::nullopt;
}

class DrnReader {
 public:
  DrnReader(LineReader lines, std::string wanted) : lines_(std::move(lines)), wanted_(std::move(wanted)) {}

  Result<Model> read() {
    if (auto ok = read_header(); !ok) {
      return tl::unexpected(ok.error());
    }
    std::string_view line;
    while (lines_.next(line)) {
      if (auto ok = read_line(line); !ok) {
        return tl::unexpected(ok.error());
      }
    }
    if (lines_.failed()) {
      return tl::unexpected(lines_.error());
    }
    if (auto ok = end_choice(); !ok) {
      return tl::unexpected(ok.error());
    }
    return finish();
  }

 private:
  template <typename... Arguments>
  tl::unexpected<Error> wrong(fmt::format_string<Arguments...> text, Arguments&&... arguments) const {
    return bad_input(fmt::format("{}: {}", lines_.where(), fmt::format(text, std::forward<Arguments>(arguments)...)));
  }

  Result<void> read_header() {
    std::string_view line;
    while (lines_.next(line)) {
      line = trimmed(line);
      if (line.empty() || line.substr(0, 2) == "//") {
        continue;
      }
      if (line == "@model") {
        return check_header();
      }
      if (auto ok = read_header_line(line); !ok) {
        return ok;
      }
    }
    return lines_.failed() ? Result<void>(tl::unexpected(lines_.error()))
                           : wrong("the end of the file: expected @model");
  }

  Result<void> read_header_line(std::string_view line) {
    if (line.front() != '@') {
      return wrong("found {}: expected a header line (@type, @reward_models, @nr_states, ..., @model)", quoted(line));
    }
    if (line.substr(0, 6) == "@type:") {
      type_ = trimmed(line.substr(6));
      if (type_ != "MDP" && type_ != "DTMC") {
        return wrong("a model of type {}: expected MDP or DTMC", quoted(type_));
      }
      return {};
    }
    if (line.substr(0, 12) == "@value_type:") {
      const std::string_view values = trimmed(line.substr(12));
      return values == "double" || values == "rational"
                 ? Result<void>()
                 : wrong("values of type {}: expected double or rational", quoted(values));
    }
    if (line.substr(0, 13) == "@placeholders") {
      return wrong("placeholders: expected plain probabilities");
    }
    const std::string keyword(line);
    std::string_view value;
    if (!lines_.next(value)) {
      return wrong("{} is the last line: expected its value on the next one", quoted(keyword));
    }
    value = trimmed(value);
    if (keyword == "@parameters") {
      return value.empty() ? Result<void>() : wrong("parameters {}: expected a model without", quoted(value));
    }
    if (keyword == "@reward_models") {
      for (std::string_view name = take_word(value); !name.empty(); name = take_word(value)) {
        reward_names_.emplace_back(name);
      }
      return {};
    }
    if (keyword == "@nr_states") {
      const auto count = to_whole(value);
      if (!count || *count == 0 || *count > kMaxStates) {
        return wrong("{} states: expected 1 to {}", quoted(value), kMaxStates);
      }
      states_ = *count;
      return {};
    }
    return keyword == "@nr_choices" ? Result<void>()
                                    : wrong("{}: no header line of DRN is known by this name", quoted(keyword));
  }

  Result<void> check_header() {
    if (type_.empty() || states_ == 0) {
      return wrong("the header has no {}", type_.empty() ? "@type" : "@nr_states");
    }
    auto weights = choose_reward(reward_names_, wanted_);
    if (!weights) {
      return in_context(lines_.where(), weights.error());
    }
    weights_ = std::move(weights->weight);
    return {};
  }

  Result<void> read_line(std::string_view line) {
    if (line.substr(0, 3) == "//[") {
      return read_valuation(line);
    }
    const std::string_view text = trimmed(line);
    if (text.empty() || line.substr(0, 2) == "//") {
      return {};
    }
    std::string_view rest = text;
    const std::string_view word = take_word(rest);
    if (word == "state") {
      return read_state(rest);
    }
    if (state_count_ == 0) {
      return wrong("found {}: expected 'state 0'", quoted(text));
    }
    return word == "action" ? read_action(rest) : read_transition(text);
  }

  // "[1, 0]" at the front of `rest`, weighted; 0 where there is none.
  Result<double> take_reward(std::string_view& rest) {
    rest = trimmed(rest);
    if (rest.empty() || rest.front() != '[') {
      return 0.0;
    }
    const std::size_t end = rest.find(']');
    if (end == std::string_view::npos) {
      return wrong("found {}: expected ']' behind the rewards", quoted(rest));
    }
    std::string_view list = rest.substr(1, end - 1);
    rest.remove_prefix(end + 1);
    double sum = 0.0;
    for (std::size_t i = 0; i < weights_.size(); ++i) {
      const std::size_t comma = list.find(',');
      const bool last = i + 1 == weights_.size();
      const auto value = to_fraction(trimmed(list.substr(0, comma)));
      if (!value || !std::isfinite(*value) || last != (comma == std::string_view::npos)) {
        return wrong("rewards {}: expected {} numbers, one for each reward model", quoted(list), weights_.size());
      }
      sum += weights_[i] * *value;
      list.remove_prefix(last ? list.size() : comma + 1);
    }
    return sum;
  }

  Result<void> read_state(std::string_view rest) {
    if (auto ok = end_choice(); !ok) {
      return ok;
    }
    const std::string_view number = take_word(rest);
    const auto state = to_whole(number);
    if (!state || *state != state_count_ || state_count_ == states_) {
      return wrong("state {}: expected {}", quoted(number),
                   state_count_ == states_ ? fmt::format("the end, after {} states", states_)
                                           : fmt::format("state {}", state_count_));
    }
    ++state_count_;
    actions_here_ = 0;
    const auto reward = take_reward(rest);
    if (!reward) {
      return tl::unexpected(reward.error());
    }
    state_reward_ = *reward;
    readings_.resize(state_count_ * model_.feature_names.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::string_view label = take_word(rest); !label.empty(); label = take_word(rest)) {
      std::vector<std::uint32_t>& labelled = model_.labels[std::string(label)];
      if (labelled.empty() || labelled.back() != *state) {
        labelled.push_back(static_cast<std::uint32_t>(*state));
      }
    }
    return {};
  }

  Result<void> read_valuation(std::string_view line) {
    if (state_count_ == 0) {
      return {};
    }
    std::string_view list = trimmed(line).substr(3);
    if (list.empty() || list.back() != ']') {
      return wrong("found {}: expected a valuation that ends with ']'", quoted(line));
    }
    list.remove_suffix(1);
    while (!list.empty()) {  // ends: every turn takes a part of the list
      const std::size_t end = list.find('&');
      const std::string_view part = list.substr(0, end);
      list.remove_prefix(end == std::string_view::npos ? list.size() : end + 1);
      const auto valuation = valuation_of(part);
      if (!valuation) {
        return wrong("a valuation {}: expected name=number, name or !name", quoted(part));
      }
      if (auto ok = set_reading(*valuation); !ok) {
        return ok;
      }
    }
    return {};
  }

  Result<void> set_reading(const Valuation& valuation) {
    auto& names = model_.feature_names;
    const std::size_t feature =
        static_cast<std::size_t>(std::find(names.begin(), names.end(), valuation.name) - names.begin());
    if (feature == names.size()) {
      first_valued_ = first_valued_ == 0 ? state_count_ : first_valued_;
      if (state_count_ != first_valued_) {
        return wrong("feature '{}' was not in the valuations before: expected the same names in every state",
                     valuation.name);
      }
      if (names.size() == kMaxModelFeatures) {
        return wrong("more than {} features", kMaxModelFeatures);
      }
      names.push_back(valuation.name);
      // States before the first valuation have none.
      readings_.assign(state_count_ * names.size(), std::numeric_limits<double>::quiet_NaN());
      for (std::size_t f = 0; f + 1 < names.size(); ++f) {
        readings_[(state_count_ - 1) * names.size() + f] = first_[f];
      }
      first_.push_back(valuation.value);
    }
    readings_[(state_count_ - 1) * names.size() + feature] = valuation.value;
    return {};
  }

  Result<void> read_action(std::string_view rest) {
    if (auto ok = end_choice(); !ok) {
      return ok;
    }
    rest = trimmed(rest);
    const std::size_t rewards = !rest.empty() && rest.back() == ']' ? rest.rfind('[') : std::string_view::npos;
    const std::string name(trimmed(rest.substr(0, rewards)));
    if (name.empty()) {
      return wrong("'action' without a name");
    }
    if (rewards == std::string_view::npos && rest.find(" [") != std::string_view::npos) {
      return wrong("found {}: expected ']' behind the rewards", quoted(rest));
    }
    rest.remove_prefix(rewards == std::string_view::npos ? rest.size() : rewards);
    const auto reward = take_reward(rest);
    if (!reward) {
      return tl::unexpected(reward.error());
    }
    return begin_choice(name, *reward);
  }

  Result<void> begin_choice(const std::string& name, double reward) {
    // A choice without a name is named by its number in the state.
    const std::string known = name == "__NOLABEL__" ? fmt::format("choice{}", actions_here_) : name;
    const auto [found, added] = action_of_.emplace(known, static_cast<std::uint32_t>(action_of_.size()));
    if (added) {
      if (action_of_.size() > kMaxActions) {
        return wrong("more than {} actions", kMaxActions);
      }
      model_.action_names.push_back(known);
    }
    ++actions_here_;
    choice_open_ = true;
    choice_action_ = found->second;
    choice_reward_ = reward;
    choice_line_ = lines_.where();
    choice_.clear();
    return {};
  }

  Result<void> read_transition(std::string_view text) {
    if (!choice_open_) {
      if (type_ != "DTMC") {
        return wrong("found {}: expected 'action NAME'", quoted(text));
      }
      if (auto ok = begin_choice("step", 0.0); !ok) {
        return ok;
      }
    }
    const std::size_t colon = text.find(':');
    const auto successor = to_whole(trimmed(text.substr(0, colon)));
    const auto probability =
        colon == std::string_view::npos ? std::nullopt : to_fraction(trimmed(text.substr(colon + 1)));
    if (!successor || *successor >= states_ || !probability) {
      return wrong("found {}: expected a state below {}, ':' and a probability", quoted(text), states_);
    }
    choice_.push_back({static_cast<std::uint32_t>(*successor), *probability});
    if (rows_.transitions() + choice_.size() > kMaxTransitions) {
      return wrong("more than {} transitions", kMaxTransitions);
    }
    return {};
  }

  Result<void> end_choice() {
    if (!choice_open_) {
      return {};
    }
    choice_open_ = false;
    auto ok = rows_.add(static_cast<std::uint32_t>(state_count_ - 1), choice_action_, state_reward_ + choice_reward_,
                        choice_);
    return ok ? Result<void>() : Result<void>(in_context(choice_line_, ok.error()));
  }

  Result<Model> finish() {
    if (state_count_ != states_) {
      return wrong("the end after {} states: expected {}", state_count_, states_);
    }
    if (model_.action_names.empty()) {
      return wrong("the end: expected choices");
    }
    if (auto ok = rows_.fill(states_, model_.action_names.size(), model_); !ok) {
      return in_context(lines_.where(), ok.error());
    }
    if (model_.feature_names.empty()) {
      model_.feature_names = {"state"};
      readings_.resize(states_);
      for (std::size_t state = 0; state < states_; ++state) {
        readings_[state] = static_cast<double>(state);
      }
    }
    model_.readings = std::move(readings_);
    fill_missing_readings();
    for (const std::uint32_t state : model_.labels["init"]) {
      model_.starts.push_back({state, 1.0 / static_cast<double>(model_.labels["init"].size())});
    }
    find_sinks(model_);
    if (auto ok = check_model(model_); !ok) {
      return in_context(lines_.where(), ok.error());
    }
    return std::move(model_);
  }

  void fill_missing_readings() {
    const std::size_t width = model_.feature_names.size();
    const auto copy = [&](std::size_t from, std::size_t to) {
      for (std::size_t f = 0; f < width; ++f) {
        double& reading = model_.readings[to * width + f];
        reading = std::isnan(reading) ? model_.readings[from * width + f] : reading;
      }
    };
    for (std::size_t row = 0; row < model_.rows(); ++row) {
      for (std::uint64_t i = model_.row_begin[row]; i < model_.row_begin[row + 1]; ++i) {
        copy(row / model_.actions(), model_.successor[i]);
      }
    }
    for (double& reading : model_.readings) {
      reading = std::isnan(reading) ? 0.0 : reading;
    }
  }

  LineReader lines_;
  std::string wanted_;
  std::string type_;
  std::vector<std::string> reward_names_;
  std::vector<double> weights_;  // [reward models]
  std::size_t states_ = 0;       // as the header says
  Model model_;
  ModelRows rows_;
  std::unordered_map<std::string, std::uint32_t> action_of_;
  std::vector<double> readings_;  // [states so far x features], NaN where a state has no valuation
  std::size_t first_valued_ = 0;  // the number of states when the first valuation was met
  std::vector<double> first_;     // that valuation so far
  std::size_t state_count_ = 0;   // so far
  std::size_t actions_here_ = 0;
  double state_reward_ = 0.0;
  bool choice_open_ = false;
  std::uint32_t choice_action_ = 0;
  double choice_reward_ = 0.0;
  std::string choice_line_;
  std::vector<ModelTransition> choice_;
};

}  // namespace

Result<Model> read_drn(const std::string& path, const std::string& reward) {
  auto lines = LineReader::open(path);
  if (!lines) {
    return tl::unexpected(lines.error());
  }
  return DrnReader(std::move(*lines), reward).read();
}

}  // namespace coppice
