#include "coordinator/exchange/prism.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <tuple>
#include <unordered_map>

#include "common/chain/chain.hpp"
#include "coordinator/exchange/line_reader.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

struct Entry {
  std::uint32_t state = 0;
  std::uint32_t choice = 0;
  std::uint32_t successor = 0;
  double number = 0.0;
};

tl::unexpected<Error> wrong(const LineReader& lines, const std::string& what) {
  return bad_input(fmt::format("{}: {}", lines.where(), what));
}

// Calls each(line) for the lines that are not blank. Errors: of the file, of each.
template <typename Each>
Result<void> each_line(LineReader& lines, const Each& each) {
  std::string_view line;
  while (lines.next(line)) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') {
      continue;
    }
    if (Result<void> ok = each(line); !ok) {
      return ok;
    }
  }
  return lines.failed() ? Result<void>(tl::unexpected(lines.error())) : Result<void>();
}

class PrismReader {
 public:
  explicit PrismReader(const std::string& path) : path_(path) {}

  Result<Model> read() {
    for (auto part : {&PrismReader::read_transitions, &PrismReader::read_states, &PrismReader::read_labels,
                      &PrismReader::read_state_rewards, &PrismReader::read_transition_rewards}) {
      if (auto ok = (this->*part)(); !ok) {
        return tl::unexpected(ok.error());
      }
    }
    if (auto ok = add_rows(); !ok) {
      return tl::unexpected(ok.error());
    }
    find_sinks(model_);
    if (auto ok = check_model(model_); !ok) {
      return in_context(path_, ok.error());
    }
    return std::move(model_);
  }

 private:
  // Nothing: there is no such file.
  std::optional<Result<LineReader>> beside(const char* extension) const {
    const std::string path = std::filesystem::path(path_).replace_extension(extension).string();
    std::error_code error;
    return std::filesystem::exists(path, error) ? std::optional(LineReader::open(path)) : std::nullopt;
  }

  Result<std::uint32_t> state_in(const LineReader& lines, std::string_view word) const {
    const auto state = to_whole(word);
    if (!state || *state >= states_) {
      return wrong(lines, fmt::format("found '{}': expected a state below {}", word, states_));
    }
    return static_cast<std::uint32_t>(*state);
  }

  // "state choice successor number [action]", or without the choice. The action's name, or nothing.
  Result<std::string_view> entry_of(const LineReader& lines, std::string_view line, Entry& entry) const {
    const auto state = state_in(lines, take_word(line));
    if (!state) {
      return tl::unexpected(state.error());
    }
    entry.state = *state;
    if (is_mdp_) {
      const std::string_view word = take_word(line);
      const auto choice = to_whole(word);
      if (!choice || *choice >= kMostChoices) {
        return wrong(lines, fmt::format("found '{}': expected a choice below {}", word, kMostChoices));
      }
      entry.choice = static_cast<std::uint32_t>(*choice);
    }
    const auto successor = state_in(lines, take_word(line));
    if (!successor) {
      return tl::unexpected(successor.error());
    }
    entry.successor = *successor;
    const std::string_view word = take_word(line);
    const auto number = to_fraction(word);
    if (!number || !std::isfinite(*number)) {
      return wrong(lines, fmt::format("found '{}': expected a number", word));
    }
    entry.number = *number;
    const std::string_view action = take_word(line);
    if (!trimmed(line).empty()) {
      return wrong(lines, fmt::format("found '{}': expected the end of the line", trimmed(line)));
    }
    return action;
  }

  Result<void> read_transitions() {
    auto lines = LineReader::open(path_);
    if (!lines) {
      return tl::unexpected(lines.error());
    }
    bool begun = false;
    auto ok = each_line(*lines, [&](std::string_view line) -> Result<void> {
      if (!begun) {
        begun = true;
        return read_counts(*lines, line);
      }
      Entry entry;
      const auto action = entry_of(*lines, line, entry);
      if (!action) {
        return tl::unexpected(action.error());
      }
      if (entries_.size() == kMaxTransitions) {
        return wrong(*lines, fmt::format("more than {} transitions", kMaxTransitions));
      }
      entries_.push_back(entry);
      const std::uint64_t pair = std::uint64_t{entry.state} << 32U | entry.choice;
      const std::string name = action->empty() ? fmt::format("choice{}", entry.choice) : std::string(*action);
      const auto [known, added] = action_of_pair_.emplace(pair, 0);
      if (added) {
        const auto [found, fresh] = action_of_.emplace(name, static_cast<std::uint32_t>(action_of_.size()));
        if (fresh && action_of_.size() > kMaxActions) {
          return wrong(*lines, fmt::format("more than {} actions", kMaxActions));
        }
        if (fresh) {
          model_.action_names.push_back(name);
        }
        known->second = found->second;
      } else if (model_.action_names[known->second] != name && !action->empty()) {
        return wrong(*lines, fmt::format("choice {} of state {} is called {} and {}", entry.choice, entry.state,
                                         model_.action_names[known->second], name));
      }
      return {};
    });
    if (ok && !begun) {
      return wrong(*lines, "no line: expected states, choices and transitions");
    }
    // So that no number in a short file asks for memory.
    if (ok && states_ > entries_.size()) {
      return wrong(*lines, fmt::format("{} transitions for {} states: expected one or more of each state",
                                       entries_.size(), states_));
    }
    return ok;
  }

  Result<void> read_counts(const LineReader& lines, std::string_view line) {
    std::vector<std::uint64_t> counts;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      const auto count = to_whole(word);
      if (!count) {
        return wrong(lines, fmt::format("found '{}': expected states, choices and transitions", word));
      }
      counts.push_back(*count);
    }
    if ((counts.size() != 2 && counts.size() != 3) || counts[0] == 0 || counts[0] > kMaxStates) {
      return wrong(lines,
                   fmt::format("expected two numbers (a chain) or three (an MDP), with 1 to {} states", kMaxStates));
    }
    states_ = counts[0];
    is_mdp_ = counts.size() == 3;
    return {};
  }

  Result<void> read_states() {
    auto lines = beside(".sta");
    if (!lines) {
      model_.feature_names = {"state"};
      model_.readings.resize(states_);
      for (std::size_t state = 0; state < states_; ++state) {
        model_.readings[state] = static_cast<double>(state);
      }
      return {};
    }
    if (!*lines) {
      return tl::unexpected(lines->error());
    }
    std::vector<bool> seen(states_, false);
    auto ok = each_line(**lines, [&](std::string_view line) -> Result<void> {
      if (model_.feature_names.empty()) {
        return read_names(**lines, line);
      }
      const std::size_t colon = line.find(':');
      const auto state = state_in(**lines, trimmed(line.substr(0, colon)));
      if (!state) {
        return tl::unexpected(state.error());
      }
      if (seen[*state]) {
        return wrong(**lines, fmt::format("state {} for a second time", *state));
      }
      seen[*state] = true;
      return read_valuation(**lines, trimmed(colon == std::string_view::npos ? "" : line.substr(colon + 1)), *state);
    });
    if (ok && std::find(seen.begin(), seen.end(), false) != seen.end()) {
      return wrong(**lines,
                   fmt::format("state {} is missing", std::find(seen.begin(), seen.end(), false) - seen.begin()));
    }
    return ok;
  }

  Result<void> read_names(const LineReader& lines, std::string_view line) {
    if (line.size() < 3 || line.front() != '(' || line.back() != ')') {
      return wrong(lines, "expected the variables, as (x,y)");
    }
    line = line.substr(1, line.size() - 2);
    while (!line.empty()) {  // ends: every turn takes a name away
      const std::size_t comma = line.find(',');
      model_.feature_names.emplace_back(trimmed(line.substr(0, comma)));
      line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
    }
    if (model_.feature_names.size() > kMaxModelFeatures) {
      return wrong(lines,
                   fmt::format("{} variables: expected at most {}", model_.feature_names.size(), kMaxModelFeatures));
    }
    model_.readings.assign(states_ * model_.feature_names.size(), 0.0);
    return {};
  }

  Result<void> read_valuation(const LineReader& lines, std::string_view list, std::uint32_t state) {
    if (list.size() < 2 || list.front() != '(' || list.back() != ')') {
      return wrong(lines, "expected STATE:(values)");
    }
    list = list.substr(1, list.size() - 2);
    const std::size_t width = model_.feature_names.size();
    for (std::size_t f = 0; f < width; ++f) {
      const std::size_t comma = list.find(',');
      const std::string_view word = trimmed(list.substr(0, comma));
      const auto number =
          word == "true" || word == "false" ? std::optional(word == "true" ? 1.0 : 0.0) : to_double(word);
      if (!number || !std::isfinite(*number) || (f + 1 == width) != (comma == std::string_view::npos)) {
        return wrong(lines, fmt::format("found '{}': expected {} values", word, width));
      }
      model_.readings[state * width + f] = *number;
      list.remove_prefix(comma == std::string_view::npos ? list.size() : comma + 1);
    }
    return {};
  }

  Result<void> read_labels() {
    auto lines = beside(".lab");
    if (!lines) {
      model_.starts = {{0, 1.0}};
      return {};
    }
    if (!*lines) {
      return tl::unexpected(lines->error());
    }
    std::vector<std::string> names;
    auto ok = each_line(**lines, [&](std::string_view line) -> Result<void> {
      if (names.empty()) {
        for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
          const std::size_t equals = word.find('=');
          const auto number = to_whole(word.substr(0, equals));
          if (!number || *number != names.size() || equals + 3 > word.size()) {
            return wrong(**lines, fmt::format("found '{}': expected {}=\"NAME\"", word, names.size()));
          }
          names.emplace_back(word.substr(equals + 2, word.size() - equals - 3));
        }
        return {};
      }
      const std::size_t colon = line.find(':');
      const auto state = state_in(**lines, trimmed(line.substr(0, colon)));
      if (!state) {
        return tl::unexpected(state.error());
      }
      std::string_view rest = colon == std::string_view::npos ? std::string_view() : line.substr(colon + 1);
      for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
        const auto label = to_whole(word);
        if (!label || *label >= names.size()) {
          return wrong(**lines, fmt::format("found '{}': expected a label below {}", word, names.size()));
        }
        model_.labels[names[*label]].push_back(*state);
      }
      return {};
    });
    if (!ok) {
      return ok;
    }
    for (auto& [name, states] : model_.labels) {
      std::sort(states.begin(), states.end());
      states.erase(std::unique(states.begin(), states.end()), states.end());
    }
    for (const std::uint32_t state : model_.labels["init"]) {
      model_.starts.push_back({state, 1.0 / static_cast<double>(model_.labels["init"].size())});
    }
    return {};
  }

  // Plain rewards, or two kinds that count against each other, as Coppice exports them.
  struct RewardFile {
    const char* extension;
    double sign;
  };

  Result<void> read_state_rewards() {
    state_reward_.assign(states_, 0.0);
    for (const RewardFile& file : {RewardFile{".srew", 1.0}, {".gain.srew", 1.0}, {".cost.srew", -1.0}}) {
      auto lines = beside(file.extension);
      if (!lines) {
        continue;
      }
      if (!*lines) {
        return tl::unexpected(lines->error());
      }
      bool begun = false;
      auto ok = each_line(**lines, [&](std::string_view line) -> Result<void> {
        if (!begun) {  // the counts
          begun = true;
          return {};
        }
        const auto state = state_in(**lines, take_word(line));
        const auto reward = to_fraction(trimmed(line));
        if (!state || !reward || !std::isfinite(*reward)) {
          return state ? Result<void>(wrong(**lines, fmt::format("found '{}': expected a reward", line)))
                       : Result<void>(tl::unexpected(state.error()));
        }
        state_reward_[*state] += file.sign * *reward;
        return {};
      });
      if (!ok) {
        return ok;
      }
    }
    return {};
  }

  Result<void> read_transition_rewards() {
    for (const RewardFile& file : {RewardFile{".trew", 1.0}, {".gain.trew", 1.0}, {".cost.trew", -1.0}}) {
      auto lines = beside(file.extension);
      if (!lines) {
        continue;
      }
      if (!*lines) {
        return tl::unexpected(lines->error());
      }
      bool begun = false;
      auto ok = each_line(**lines, [&](std::string_view line) -> Result<void> {
        if (!begun) {
          begun = true;
          return {};
        }
        Entry entry;
        const auto action = entry_of(**lines, line, entry);
        if (!action) {
          return tl::unexpected(action.error());
        }
        entry.number *= file.sign;
        rewards_.push_back(entry);
        return {};
      });
      if (!ok) {
        return ok;
      }
    }
    sort(rewards_);
    return {};
  }

  static std::tuple<std::uint32_t, std::uint32_t, std::uint32_t> place(const Entry& entry) {
    return {entry.state, entry.choice, entry.successor};
  }
  static void sort(std::vector<Entry>& entries) {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return place(a) < place(b); });
  }

  Result<void> reward_of_nothing(const Entry& entry) const {
    const std::string choice = is_mdp_ ? fmt::format(", choice {}", entry.choice) : "";
    return bad_input(
        fmt::format("{}: a .trew file has a reward from state {}{} to state {}: expected only transitions "
                    "that are here",
                    path_, entry.state, choice, entry.successor));
  }

  Result<void> add_rows() {
    sort(entries_);
    ModelRows rows;
    auto reward = rewards_.begin();
    std::vector<ModelTransition> transitions;
    for (std::size_t i = 0; i < entries_.size();) {  // ends: every turn takes a choice
      const Entry& first = entries_[i];
      double sum = state_reward_[first.state];
      transitions.clear();
      for (; i < entries_.size() && entries_[i].state == first.state && entries_[i].choice == first.choice; ++i) {
        transitions.push_back({entries_[i].successor, entries_[i].number});
        if (reward != rewards_.end() && place(*reward) < place(entries_[i])) {
          return reward_of_nothing(*reward);
        }
        for (; reward != rewards_.end() && place(*reward) == place(entries_[i]); ++reward) {
          sum += reward->number * entries_[i].number;
        }
      }
      const std::uint32_t action = action_of_pair_.at(std::uint64_t{first.state} << 32U | first.choice);
      if (auto ok = rows.add(first.state, action, sum, transitions); !ok) {
        return in_context(path_, ok.error());
      }
    }
    if (model_.action_names.empty()) {
      return bad_input(fmt::format("{}: no transitions", path_));
    }
    if (reward != rewards_.end()) {
      return reward_of_nothing(*reward);
    }
    auto ok = rows.fill(states_, model_.action_names.size(), model_);
    return ok ? ok : in_context(path_, ok.error());
  }

  static constexpr std::uint64_t kMostChoices = std::uint64_t{1} << 16U;

  std::string path_;
  std::size_t states_ = 0;
  bool is_mdp_ = false;
  Model model_;
  std::vector<Entry> entries_;
  std::vector<Entry> rewards_;
  std::vector<double> state_reward_;
  std::unordered_map<std::string, std::uint32_t> action_of_;
  std::unordered_map<std::uint64_t, std::uint32_t> action_of_pair_;  // state and choice
};

}  // namespace

Result<Model> read_prism(const std::string& path) { return PrismReader(path).read(); }

}  // namespace coppice
