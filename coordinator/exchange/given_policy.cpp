#include "coordinator/exchange/given_policy.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <optional>

#include "common/check.hpp"
#include "coordinator/exchange/line_reader.hpp"
#include "coordinator/exchange/npy.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

// A table: numbers by state, however the states are named.
struct Table {
  NumberArray array;  // bare numbers: the states by number, or by whole-number readings
  std::map<std::vector<double>, std::vector<double>> by_readings;  // with a header: readings of all features -> row
  std::size_t width = 0;                                           // of a row
  bool named = false;
};

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {  // ends: every turn takes a field away
    const std::size_t comma = line.find(',');
    std::string_view field = trimmed(line.substr(0, comma));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') {
      field = field.substr(1, field.size() - 2);
    }
    fields.push_back(field);
    if (comma == std::string_view::npos) {
      return fields;
    }
    line.remove_prefix(comma + 1);
  }
}

// "nan", "-inf" and blanks stand for what is not there.
std::optional<double> value_in(std::string_view field) {
  if (field.empty() || field == "nan" || field == "NaN") {
    return kMissing;
  }
  const auto number = to_double(field);
  return number && *number == -std::numeric_limits<double>::infinity() ? std::optional(kMissing) : number;
}

class CsvTable {
 public:
  CsvTable(LineReader lines, const Model& model, bool is_q) : lines_(std::move(lines)), model_(model), is_q_(is_q) {}

  Result<Table> read() {
    std::string_view line;
    while (lines_.next(line)) {
      if (lines_.line_number() == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") {
        line.remove_prefix(3);
      }
      if (trimmed(line).empty() || line.front() == '#') {
        continue;
      }
      const auto fields = fields_of(line);
      if (!begun_) {
        begun_ = true;
        columns_ = fields.size();
        const bool header =
            std::any_of(fields.begin(), fields.end(), [](std::string_view field) { return !value_in(field); });
        if (header) {
          if (auto ok = read_header(fields); !ok) {
            return tl::unexpected(ok.error());
          }
          continue;
        }
      }
      if (fields.size() != columns_) {
        return wrong(fmt::format("{} fields: expected {}", fields.size(), columns_));
      }
      if (auto ok = table_.named ? read_named(fields) : read_bare(fields); !ok) {
        return tl::unexpected(ok.error());
      }
    }
    if (lines_.failed()) {
      return tl::unexpected(lines_.error());
    }
    if (!table_.named) {
      if (table_.array.values.empty()) {
        return wrong("no numbers: expected a line for each state");
      }
      table_.array.shape = {table_.array.values.size() / columns_};
      if (columns_ > 1) {
        table_.array.shape.push_back(columns_);
      }
    }
    return std::move(table_);
  }

 private:
  tl::unexpected<Error> wrong(const std::string& what) const {
    return bad_input(fmt::format("{}: {}", lines_.where(), what));
  }

  Result<void> read_header(const std::vector<std::string_view>& fields) {
    table_.named = true;
    table_.width = is_q_ ? model_.actions() : 1;
    const auto column = [&](std::string_view name) {
      return static_cast<std::size_t>(std::find(fields.begin(), fields.end(), name) - fields.begin());
    };
    for (const std::string& name : model_.feature_names) {
      features_.push_back(column(name));
      if (features_.back() == fields.size()) {
        return wrong(fmt::format("no column '{}': expected one for each feature ({})", name,
                                 fmt::join(model_.feature_names, ", ")));
      }
    }
    if (!is_q_) {
      values_.push_back(column("action"));
      return values_[0] < fields.size() ? Result<void>() : wrong("no column 'action'");
    }
    for (const std::string& name : model_.action_names) {
      values_.push_back(column(name));
      if (values_.back() == fields.size()) {
        return wrong(fmt::format("no column '{}': expected one for each action ({})", name,
                                 fmt::join(model_.action_names, ", ")));
      }
    }
    return {};
  }

  Result<void> read_named(const std::vector<std::string_view>& fields) {
    std::vector<double> readings;
    for (const std::size_t column : features_) {
      const auto reading = to_double(fields[column]);
      if (!reading) {
        return wrong(fmt::format("found '{}': expected a number", fields[column]));
      }
      readings.push_back(*reading);
    }
    std::vector<double> values;
    for (const std::size_t column : values_) {
      auto value = value_in(fields[column]);
      if (!is_q_) {
        const auto named = std::find(model_.action_names.begin(), model_.action_names.end(), fields[column]);
        value = named != model_.action_names.end()
                    ? std::optional(static_cast<double>(named - model_.action_names.begin()))
                    : value;
      }
      if (!value) {
        return wrong(fmt::format("found '{}': expected {}", fields[column], is_q_ ? "a number" : "an action"));
      }
      values.push_back(*value);
    }
    if (!table_.by_readings.emplace(std::move(readings), std::move(values)).second) {
      return wrong("these readings have a line already: expected one each");
    }
    return {};
  }

  Result<void> read_bare(const std::vector<std::string_view>& fields) {
    for (const std::string_view field : fields) {
      const auto value = value_in(field);
      if (!value) {
        return wrong(fmt::format("found '{}': expected a number", field));
      }
      table_.array.values.push_back(*value);
    }
    return {};
  }

  LineReader lines_;
  const Model& model_;
  bool is_q_;
  bool begun_ = false;
  std::size_t columns_ = 0;
  std::vector<std::size_t> features_;
  std::vector<std::size_t> values_;
  Table table_;
};

Result<Table> read_table(const std::string& path, const Model& model, bool is_q) {
  const auto first = first_bytes(path, 8);
  if (!first) {
    return tl::unexpected(first.error());
  }
  if (!is_npy(*first)) {
    auto lines = LineReader::open(path);
    return lines ? CsvTable(std::move(*lines), model, is_q).read() : tl::unexpected(lines.error());
  }
  auto array = read_npy(path);
  if (!array) {
    return tl::unexpected(array.error());
  }
  for (double& value : array->values) {
    value = value == -std::numeric_limits<double>::infinity() ? kMissing : value;
  }
  Table table;
  table.array = std::move(*array);
  return table;
}

// How many states of the source there may be: the largest number, and one.
std::size_t source_states(const Model& model) {
  std::size_t states = 0;
  for (std::uint32_t state = 0; state < model.states(); ++state) {
    states = std::max<std::size_t>(states, std::size_t{model.source_of(state)} + 1);
  }
  return states;
}

// Checks the shape; by_number: rows are the source's states, else whole-number readings.
Result<bool> is_by_number(const std::string& path, Table& table, const Model& model, bool is_q) {
  std::vector<std::size_t> states = table.array.shape;
  table.width = 1;
  if (is_q) {
    table.width = states.back();
    states.pop_back();
    if (table.width != model.actions()) {
      return bad_input(fmt::format("{}: shape ({}): expected the last to be {}, the number of actions", path,
                                   fmt::join(table.array.shape, ", "), model.actions()));
    }
  }
  const std::size_t wanted = source_states(model);
  const bool one_feature = model.feature_names.size() == 1;
  if (states.size() == 1 && states[0] >= wanted) {
    return true;
  }
  if (states.size() == model.feature_names.size() && (!one_feature || states[0] < wanted)) {
    return false;
  }
  return bad_input(fmt::format("{}: shape ({}): expected {} states or more, or {} whole-number features{}", path,
                               fmt::join(table.array.shape, ", "), wanted, model.feature_names.size(),
                               is_q ? ", then the actions" : ""));
}

// The row of a state: nothing where the table has none.
std::span<const double> row_of(const Table& table, bool by_number, const Model& model, std::uint32_t state) {
  const auto readings = model.readings_of(state);
  if (table.named) {
    const auto found = table.by_readings.find(std::vector<double>(readings.begin(), readings.end()));
    return found == table.by_readings.end() ? std::span<const double>() : std::span<const double>(found->second);
  }
  std::size_t place = 0;
  if (by_number) {
    place = model.source_of(state);
  } else {
    for (std::size_t f = 0; f < readings.size(); ++f) {
      const double reading = readings[f];
      if (!(reading >= 0.0) || reading != std::floor(reading) || reading >= static_cast<double>(table.array.shape[f])) {
        return {};
      }
      place = place * table.array.shape[f] + static_cast<std::size_t>(reading);
    }
  }
  return std::span<const double>(table.array.values).subspan(place * table.width, table.width);
}

std::uint8_t first_action(const Model& model, std::uint32_t state) {
  for (std::size_t action = 0; action < model.actions(); ++action) {
    const std::size_t row = state * model.actions() + action;
    if (model.row_begin[row + 1] > model.row_begin[row]) {
      return static_cast<std::uint8_t>(action);
    }
  }
  return 0;
}

bool has(const Model& model, std::uint32_t state, std::size_t action) {
  const std::size_t row = state * model.actions() + action;
  return model.row_begin[row + 1] > model.row_begin[row];
}

Result<void> read_q(const std::string& path, const Model& model, GivenPolicy& given) {
  auto table = read_table(path, model, true);
  if (!table) {
    return tl::unexpected(table.error());
  }
  bool by_number = false;
  if (!table->named) {
    const auto found = is_by_number(path, *table, model, true);
    if (!found) {
      return tl::unexpected(found.error());
    }
    by_number = *found;
  }
  given.q.assign(model.rows(), kMissing);
  for (std::uint32_t state = 0; state < model.states(); ++state) {
    given.policy.push_back(ActionId{first_action(model, state)});
    const auto row = row_of(*table, by_number, model, state);
    if (row.empty()) {
      given.unlisted += model.is_terminal(state) ? 0 : 1;
      continue;
    }
    std::optional<double> best;
    std::uint64_t as_good = 0;
    bool zeros = true;
    for (std::size_t action = 0; action < row.size(); ++action) {
      if (std::isinf(row[action])) {
        return bad_input(fmt::format("{}: the value of state {}, action {} is infinite: expected a number", path,
                                     model.source_of(state), action));
      }
      given.q[state * model.actions() + action] = row[action];
      if (std::isnan(row[action]) || !has(model, state, action)) {
        continue;
      }
      zeros = zeros && row[action] == 0.0;
      as_good = !best || row[action] > *best ? 1 : as_good + (row[action] == *best ? 1 : 0);
      if (!best || row[action] > *best) {
        best = row[action];
        given.policy.back() = ActionId{static_cast<std::uint8_t>(action)};
      }
    }
    if (!model.is_terminal(state)) {
      given.unvisited += zeros ? 1 : 0;
      given.ties += !zeros && as_good > 1 ? 1 : 0;
    }
  }
  return {};
}

Result<void> read_policy(const std::string& path, const Model& model, GivenPolicy& given) {
  auto table = read_table(path, model, false);
  if (!table) {
    return tl::unexpected(table.error());
  }
  bool by_number = false;
  if (!table->named) {
    const auto found = is_by_number(path, *table, model, false);
    if (!found) {
      return tl::unexpected(found.error());
    }
    by_number = *found;
  }
  given.policy.assign(model.states(), ActionId{0});
  for (std::uint32_t state = 0; state < model.states(); ++state) {
    const auto row = row_of(*table, by_number, model, state);
    given.policy[state] = ActionId{first_action(model, state)};
    if (row.empty() || std::isnan(row[0])) {
      given.unlisted += model.is_terminal(state) ? 0 : 1;
      continue;
    }
    const double action = row[0];
    if (!(action >= 0.0 && action < static_cast<double>(model.actions()) && action == std::floor(action))) {
      return bad_input(fmt::format("{}: state {} has action {}: expected an index below {}", path,
                                   model.source_of(state), action, model.actions()));
    }
    if (!model.is_terminal(state) && !has(model, state, static_cast<std::size_t>(action))) {
      return bad_input(fmt::format("{}: state {} has action {}, which the state lacks", path, model.source_of(state),
                                   model.action_names[static_cast<std::size_t>(action)]));
    }
    given.policy[state] = ActionId{static_cast<std::uint8_t>(action)};
  }
  return {};
}

}  // namespace

Result<GivenPolicy> read_given_policy(const std::string& q_path, const std::string& policy_path, const Model& model) {
  COPPICE_CHECK(!q_path.empty() || !policy_path.empty());
  GivenPolicy given;
  if (!q_path.empty()) {
    if (auto ok = read_q(q_path, model, given); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  if (!policy_path.empty()) {
    given.ties = 0;
    given.unlisted = 0;
    if (auto ok = read_policy(policy_path, model, given); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  return given;
}

Result<void> forbid(const GivenPolicy& given, Model& model) {
  if (given.q.empty()) {
    return {};
  }
  const std::size_t actions = model.actions();
  std::vector<std::uint64_t> begin{0};
  std::size_t kept = 0;
  for (std::uint32_t state = 0; state < model.states(); ++state) {
    const std::size_t first = state * actions;
    // A row of nothing but NaN is a state that the table does not have.
    const bool listed = std::any_of(given.q.begin() + static_cast<std::ptrdiff_t>(first),
                                    given.q.begin() + static_cast<std::ptrdiff_t>(first + actions),
                                    [](double q) { return !std::isnan(q); });
    bool some = false;
    bool had = false;
    for (std::size_t row = first; row < first + actions; ++row) {
      const std::uint64_t row_begin = model.row_begin[row];
      const std::uint64_t row_end = model.row_begin[row + 1];
      const bool goes = listed && std::isnan(given.q[row]) && !model.is_terminal(state);
      had = had || row_end > row_begin;
      for (std::uint64_t i = row_begin; i < row_end && !goes; ++i) {
        model.successor[kept] = model.successor[i];
        model.probability[kept] = model.probability[i];
        ++kept;
        some = true;
      }
      model.reward[row] = goes ? 0.0 : model.reward[row];
      if (!model.collision.empty()) {
        model.collision[row] = goes ? 0.0 : model.collision[row];
      }
      begin.push_back(kept);
    }
    if (had && !some) {
      return bad_input(fmt::format("the Q-table forbids every action that state {} has", model.source_of(state)));
    }
  }
  model.row_begin = std::move(begin);
  model.successor.resize(kept);
  model.probability.resize(kept);
  return {};
}

}  // namespace coppice
