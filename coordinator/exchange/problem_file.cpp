#include "coordinator/exchange/problem_file.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>

#include "common/toml.hpp"
#include "coordinator/exchange/line_reader.hpp"
#include "coordinator/exchange/text_number.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{16} << 20U;

// Reads one file; every error names file, line and key.
class TomlReader {
 public:
  explicit TomlReader(std::string path) : path_(std::move(path)) {}

  Result<ProblemFile> read(const toml::table& root) {
    auto ok = keys("", root,
                   {{"title", [&](const auto& node) { return text("title", node, file_.title); }},
                    {"simulator", [&](const auto& node) { return text("simulator", node, file_.simulator); }},
                    {"reward", [&](const auto& node) { return text("reward", node, file_.reward); }},
                    {"discount", [&](const auto& node) { return share("discount", node, file_.discount); }},
                    {"no_action", [&](const auto& node) { return text("no_action", node, file_.no_action); }},
                    {"terminal", [&](const auto& node) { return read_terminal(node); }},
                    {"look_alikes", [&](const auto& node) { return read_look_alikes(node); }},
                    {"without_actions", [&](const auto& node) { return texts("without_actions", node); }},
                    {"features", [&](const auto& node) { return read_features(node); }},
                    {"actions", [&](const auto& node) { return read_actions(node); }},
                    {"collisions", [&](const auto& node) { return read_collisions(node); }},
                    {"terminals", [&](const auto& node) { return choice("terminals", node, file_.terminals); }},
                    {"initial", [&](const auto& node) { return choice("initial", node, file_.initial); }}});
    return ok ? Result<ProblemFile>(std::move(file_)) : tl::unexpected(ok.error());
  }

 private:
  using Read = std::function<Result<void>(const toml::node&)>;

  tl::unexpected<Error> wrong(const toml::node& node, const std::string& key, const std::string& expected) const {
    return bad_input(fmt::format("{}: line {}: {}: expected {}", path_, node.source().begin.line, key, expected));
  }

  // Every key of the table by its reader.
  Result<void> keys(const std::string& place, const toml::table& table, const std::map<std::string, Read>& readers) {
    for (const auto& [key, node] : table) {
      const auto found = readers.find(std::string(key.str()));
      if (found == readers.end()) {
        std::string known;
        for (const auto& [name, read] : readers) {
          known += (known.empty() ? "" : ", ") + name;
        }
        return wrong(node, fmt::format("{}{}", place, key.str()), "one of " + known);
      }
      if (auto ok = found->second(node); !ok) {
        return ok;
      }
    }
    return {};
  }

  Result<void> text(const std::string& key, const toml::node& node, std::string& into) const {
    const auto value = node.value_exact<std::string>();
    if (!value || value->size() > kMaxSimulatorCommand) {
      return wrong(node, key, fmt::format("a text of at most {} characters", kMaxSimulatorCommand));
    }
    into = *value;
    return {};
  }

  Result<void> number(const std::string& key, const toml::node& node, std::optional<double>& into) const {
    into = node.is_number() ? node.value<double>() : std::nullopt;
    return into ? Result<void>() : wrong(node, key, "a number");
  }

  Result<void> share(const std::string& key, const toml::node& node, std::optional<double>& into) const {
    into = node.is_number() ? node.value<double>() : std::nullopt;
    return into && *into >= 0.0 && *into <= 1.0 ? Result<void>() : wrong(node, key, "a number from 0 to 1");
  }

  Result<void> texts(const std::string& key, const toml::node& node) {
    const toml::array* array = node.as_array();
    if (array == nullptr) {
      return wrong(node, key, "a list of names");
    }
    for (const toml::node& entry : *array) {
      const auto name = entry.value_exact<std::string>();
      if (!name) {
        return wrong(entry, key, "a list of names");
      }
      file_.without_actions.push_back(*name);
    }
    return {};
  }

  Result<void> read_terminal(const toml::node& node) {
    const auto value = node.value_exact<std::string>();
    if (value != "absorb" && value != "again") {
      return wrong(node, "terminal", "\"absorb\" or \"again\"");
    }
    file_.terminal = value == "again" ? WhenTerminal::again : WhenTerminal::absorb;
    return {};
  }

  Result<void> read_look_alikes(const toml::node& node) {
    const auto value = node.value_exact<std::string>();
    if (value != "apart" && value != "merge") {
      return wrong(node, "look_alikes", "\"apart\" or \"merge\"");
    }
    file_.look_alikes = value == "merge" ? LookAlikes::merge : LookAlikes::apart;
    return {};
  }

  Result<void> read_features(const toml::node& node) {
    const toml::table* table = node.as_table();
    if (table == nullptr) {
      return wrong(node, "features", "a table, one entry for each feature");
    }
    for (const auto& [key, entry] : *table) {
      const std::string name(key.str());
      const std::string place = fmt::format("features.{}.", name);
      const toml::table* feature = entry.as_table();
      if (feature == nullptr) {
        return wrong(entry, "features." + name, "a table");
      }
      FeatureWish& wish = file_.features[name];
      auto ok = keys(place, *feature,
                     {{"name", [&](const auto& value) { return text(place + "name", value, wish.name); }},
                      {"label", [&](const auto& value) { return text(place + "label", value, wish.label); }},
                      {"unit", [&](const auto& value) { return text(place + "unit", value, wish.unit); }},
                      {"values", [&](const auto& value) { return read_values(place + "values", value, wish); }},
                      {"bins", [&](const auto& value) { return read_bins(place + "bins", value, wish); }},
                      {"operators", [&](const auto& value) { return read_operators(place, value, wish); }}});
      if (!ok) {
        return ok;
      }
    }
    return {};
  }

  Result<void> read_values(const std::string& key, const toml::node& node, FeatureWish& wish) const {
    const toml::table* table = node.as_table();
    if (table == nullptr) {
      return wrong(node, key, "a table of labels, as { 0 = \"wall\", 1 = \"free\" }");
    }
    for (const auto& [value, label] : *table) {
      const auto reading = to_double(value.str());
      if (!reading) {
        return wrong(label, fmt::format("{}.{}", key, value.str()), "a number as key");
      }
      if (auto ok = text(fmt::format("{}.{}", key, value.str()), label, wish.values[*reading]); !ok) {
        return ok;
      }
    }
    return {};
  }

  // [0.1, 0.5], { quantiles = 8 } or { entropy = 8 }.
  Result<void> read_bins(const std::string& key, const toml::node& node, FeatureWish& wish) const {
    Binning binning;
    if (const toml::array* edges = node.as_array()) {
      binning.kind = Binning::Kind::edges;
      for (const toml::node& edge : *edges) {
        std::optional<double> number_read;
        if (auto ok = number(key, edge, number_read); !ok) {
          return ok;
        }
        binning.edges.push_back(*number_read);
      }
      wish.binning = binning;
      return {};
    }
    const toml::table* table = node.as_table();
    const bool quantiles = table != nullptr && table->contains("quantiles");
    const bool entropy = table != nullptr && table->contains("entropy");
    if (quantiles == entropy || table->size() != 1) {
      return wrong(node, key, "a list of edges, { quantiles = N } or { entropy = N }");
    }
    const auto bins = (*table)[quantiles ? "quantiles" : "entropy"].value_exact<std::int64_t>();
    if (!bins || *bins < 2 || *bins > static_cast<std::int64_t>(kMaxValues)) {
      return wrong(node, key, fmt::format("2 to {} bins", kMaxValues));
    }
    binning.kind = quantiles ? Binning::Kind::quantiles : Binning::Kind::entropy;
    binning.bins = static_cast<std::size_t>(*bins);
    wish.binning = binning;
    return {};
  }

  Result<void> read_operators(const std::string& place, const toml::node& node, FeatureWish& wish) const {
    const toml::array* array = node.as_array();
    wish.admits_equal = false;
    wish.admits_less_equal = false;
    bool fits = array != nullptr && !array->empty();
    if (fits) {
      for (const toml::node& entry : *array) {
        const auto op = entry.value_exact<std::string>();
        wish.admits_equal = *wish.admits_equal || op == "=";
        wish.admits_less_equal = *wish.admits_less_equal || op == "<=";
        fits = fits && (op == "=" || op == "<=");
      }
    }
    return fits ? Result<void>() : wrong(node, place + "operators", "a list of \"=\" and \"<=\"");
  }

  Result<void> read_actions(const toml::node& node) {
    const toml::table* table = node.as_table();
    if (table == nullptr) {
      return wrong(node, "actions", "a table, one entry for each action");
    }
    for (const auto& [key, entry] : *table) {
      const std::string name(key.str());
      const std::string place = fmt::format("actions.{}.", name);
      ActionWish& wish = file_.actions[name];
      const toml::table* action = entry.as_table();
      if (action == nullptr) {
        return wrong(entry, "actions." + name, "a table");
      }
      auto ok = keys(place, *action,
                     {{"name", [&](const auto& value) { return text(place + "name", value, wish.name); }},
                      {"label", [&](const auto& value) { return text(place + "label", value, wish.label); }}});
      if (!ok) {
        return ok;
      }
    }
    return {};
  }

  Result<void> read_collisions(const toml::node& node) {
    const toml::table* table = node.as_table();
    if (table == nullptr || table->size() != 1) {
      return wrong(node, "collisions", "one of: reward = NUMBER, when = \"TEST\", label = \"NAME\"");
    }
    if (const toml::node* reward = table->get("reward")) {
      return number("collisions.reward", *reward, file_.collision_reward);
    }
    return choice("collisions", node, file_.collisions);
  }

  // { when = "x=3" }, { label = "goal" }, or { shares = { 0 = 3, 7 = 1 } } by the states' numbers.
  Result<void> choice(const std::string& key, const toml::node& node, StateChoice& into) {
    const toml::table* table = node.as_table();
    if (table == nullptr || table->size() != 1) {
      return wrong(node, key, "one of: when = \"TEST\", label = \"NAME\", shares = { STATE = SHARE }");
    }
    return keys(key + ".", *table,
                {{"when", [&](const auto& value) { return text(key + ".when", value, into.when); }},
                 {"label", [&](const auto& value) { return text(key + ".label", value, into.label); }},
                 {"shares", [&](const auto& value) { return shares(key + ".shares", value, into); }}});
  }

  Result<void> shares(const std::string& key, const toml::node& node, StateChoice& into) const {
    const toml::table* table = node.as_table();
    if (table == nullptr || table->empty()) {
      return wrong(node, key, "a table of shares, as { 0 = 3, 7 = 1 }");
    }
    for (const auto& [state, value] : *table) {
      const auto index = to_whole(state.str());
      const double share_read = value.is_number() ? value.value_or(0.0) : 0.0;
      if (!index || *index > UINT32_MAX || !(share_read > 0.0)) {
        return wrong(value, fmt::format("{}.{}", key, state.str()), "a state's number and a share above 0");
      }
      into.shares[static_cast<std::uint32_t>(*index)] = share_read;
    }
    return {};
  }

  std::string path_;
  ProblemFile file_;
};

}  // namespace

Result<ProblemFile> read_problem_file(const std::string& path) {
  auto bytes = first_bytes(path, kMaxBytes);
  if (!bytes) {
    return tl::unexpected(bytes.error());
  }
  if (bytes->size() == kMaxBytes) {
    return bad_input(fmt::format("{}: {} bytes or more: expected a problem file", path, kMaxBytes));
  }
  const Result<toml::table> root = parse_toml(*bytes, path);
  return root ? TomlReader(path).read(*root) : tl::unexpected(root.error());
}

}  // namespace coppice
