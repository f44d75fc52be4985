#include "coordinator/sweep/plan.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <iterator>
#include <set>

#include "common/toml.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/report/score.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMaxSweepBytes = std::size_t{1} << 20U;
constexpr std::int64_t kMaxSeeds = 100'000;

// One key of the grid with the values that it takes.
struct Axis {
  std::string key;
  std::vector<std::string> values;
};

class SweepReader {
 public:
  SweepReader(const std::string& name, const Vocabulary& vocabulary) : name_(name), vocabulary_(vocabulary) {}

  Result<SweepPlan> read(const toml::table& root) {
    for (const auto& [key, node] : root) {
      Result<void> ok;
      if (key == "config") {
        ok = read_config_file(node);
      } else if (key == "seeds") {
        ok = read_seeds(node);
      } else if (key == "episodes") {
        ok = read_episodes(node);
      } else if (key != "set" && key != "grid") {
        ok = at(key.source(),
                fmt::format("unknown key '{}': expected one of config, seeds, episodes, [set], [grid]", key.str()));
      }
      if (!ok) {
        return tl::unexpected(ok.error());
      }
    }
    if (const toml::node* const set = root.get("set"); set != nullptr) {
      if (auto ok = read_table("set", *set, [&](const auto& key, const toml::node& node) { return apply(key, node); });
          !ok) {
        return tl::unexpected(ok.error());
      }
    }
    if (const toml::node* const grid = root.get("grid"); grid != nullptr) {
      if (auto ok = read_table("grid", *grid, [&](const auto& key, const toml::node& node) { return add(key, node); });
          !ok) {
        return tl::unexpected(ok.error());
      }
    }
    if (plan_.seeds.empty()) {
      return bad_input(fmt::format("{}: no seeds: expected seeds = 10, or a list of seeds", name_));
    }
    return combine();
  }

 private:
  tl::unexpected<Error> at(const toml::source_region& place, const std::string& what) const {
    return bad_input(fmt::format("{}: line {}: {}", name_, place.begin.line, what));
  }
  tl::unexpected<Error> at(const toml::source_region& place, const Error& error) const {
    return at(place, error.message);
  }

  Result<void> read_config_file(const toml::node& node) {
    const auto file = node.value_exact<std::string>();
    if (!file) {
      return at(node.source(), "config: expected the name of a file, in quotes");
    }
    const std::filesystem::path path = std::filesystem::path(name_).parent_path() / *file;
    auto ok = load_config(path.string(), base_);
    return ok ? Result<void>() : in_context(fmt::format("{}: line {}", name_, node.source().begin.line), ok.error());
  }

  Result<void> read_seeds(const toml::node& node) {
    constexpr const char* kExpected = "expected how many, 1 to {}, or a list of different whole numbers from 0 on";
    if (const auto count = node.value_exact<std::int64_t>(); count && *count >= 1 && *count <= kMaxSeeds) {
      for (std::int64_t seed = 1; seed <= *count; ++seed) {
        plan_.seeds.push_back(static_cast<std::uint64_t>(seed));
      }
      return {};
    }
    const toml::array* const list = node.as_array();
    if (list == nullptr || list->empty() || list->size() > static_cast<std::size_t>(kMaxSeeds)) {
      return at(node.source(), "seeds: " + fmt::format(kExpected, kMaxSeeds));
    }
    std::set<std::int64_t> met;
    for (const toml::node& element : *list) {
      const auto seed = element.value_exact<std::int64_t>();
      if (!seed || *seed < 0 || !met.insert(*seed).second) {
        return at(element.source(), "seeds: " + fmt::format(kExpected, kMaxSeeds));
      }
      plan_.seeds.push_back(static_cast<std::uint64_t>(*seed));
    }
    return {};
  }

  Result<void> read_episodes(const toml::node& node) {
    const auto episodes = node.value_exact<std::int64_t>();
    if (!episodes || *episodes < 0) {
      return at(node.source(), "episodes: expected a whole number, 2 or more, or 0 for no simulation");
    }
    plan_.episodes = static_cast<std::uint64_t>(*episodes);
    if (plan_.episodes != 0) {
      SimulateSettings settings;
      settings.episodes = plan_.episodes;
      if (auto ok = check_score_settings(settings, "episodes"); !ok) {
        return at(node.source(), ok.error());
      }
    }
    return {};
  }

  // Calls read(key, node) for every value in the table, and in the tables in it that sections are.
  template <typename Read>
  Result<void> read_table(const std::string& name, const toml::node& node, const Read& read,
                          const std::string& prefix = {}) {
    const toml::table* const table = node.as_table();
    if (table == nullptr) {
      return at(node.source(), fmt::format("{0}: expected a table [{0}]", name));
    }
    for (const auto& [key, value] : *table) {
      const std::string full = prefix + std::string(key.str());
      const bool nested = prefix.empty() && value.is_table();
      if (auto ok = nested ? read_table(name, value, read, full + ".") : read(full, value); !ok) {
        return ok;
      }
    }
    return {};
  }

  Result<std::string> text_of(const std::string& key, const toml::node& node) const {
    if (const auto integer = node.value_exact<std::int64_t>()) {
      return fmt::format("{}", *integer);
    }
    if (const auto real = node.value_exact<double>()) {
      return fmt::format("{}", *real);
    }
    if (auto text = node.value_exact<std::string>()) {
      return std::move(*text);
    }
    return at(node.source(), fmt::format("{}: expected a number or a text", key));
  }

  Result<void> apply(const std::string& key, const toml::node& node) {
    const auto text = text_of(key, node);
    if (!text) {
      return tl::unexpected(text.error());
    }
    auto ok = key == "seed" ? seed_is_no_key() : assign_text(key, *text, base_);
    return ok ? Result<void>() : at(node.source(), ok.error());
  }

  Result<void> add(const std::string& key, const toml::node& node) {
    const toml::array* const list = node.as_array();
    if (list == nullptr || list->empty()) {
      return at(node.source(), fmt::format("{}: expected a list of values, such as [50, 100]", key));
    }
    Axis axis{key, {}};
    for (const toml::node& element : *list) {
      auto text = text_of(key, element);
      if (!text) {
        return tl::unexpected(text.error());
      }
      EvolveConfig tried = base_;
      if (auto ok = key == "seed" ? seed_is_no_key() : assign_text(key, *text, tried); !ok) {
        return at(element.source(), ok.error());
      }
      if (std::find(axis.values.begin(), axis.values.end(), *text) != axis.values.end()) {
        return at(element.source(), fmt::format("{}: {} is there twice", key, *text));
      }
      axis.values.push_back(std::move(*text));
    }
    axes_.push_back(std::move(axis));
    return {};
  }

  static Result<void> seed_is_no_key() { return bad_input("seed: expected in `seeds`, at the top of the file"); }

  Result<SweepPlan> combine() {
    std::size_t settings = 1;
    for (const Axis& axis : axes_) {
      plan_.keys.push_back(axis.key);
      settings = std::min(settings * axis.values.size(), kMaxSweepRuns + 1);
    }
    if (settings * plan_.seeds.size() > kMaxSweepRuns) {
      return bad_input(fmt::format("{}: more than {} runs", name_, kMaxSweepRuns));
    }
    for (std::size_t i = 0; i < settings; ++i) {
      SweepSetting setting{std::vector<std::string>(axes_.size()), base_};
      std::size_t rest = i;
      for (std::size_t a = axes_.size(); a-- > 0;) {
        const Axis& axis = axes_[a];
        setting.values[a] = axis.values[rest % axis.values.size()];
        rest /= axis.values.size();
        if (auto ok = assign_text(axis.key, setting.values[a], setting.config); !ok) {
          return in_context(name_, ok.error());
        }
      }
      plan_.settings.push_back(std::move(setting));
      if (auto ok = check_config(plan_.settings.back().config, vocabulary_); !ok) {
        return in_context(fmt::format("{}: {}", name_, plan_.label(i)), ok.error());
      }
    }
    return std::move(plan_);
  }

  const std::string& name_;
  const Vocabulary& vocabulary_;
  EvolveConfig base_;
  std::vector<Axis> axes_;
  SweepPlan plan_;
};

}  // namespace

std::vector<SweepRun> SweepPlan::runs() const {
  std::vector<SweepRun> all;
  all.reserve(settings.size() * seeds.size());
  for (std::size_t setting = 0; setting < settings.size(); ++setting) {
    for (const std::uint64_t seed : seeds) {
      all.push_back({setting, settings[setting].config});
      all.back().config.seed = seed;
    }
  }
  return all;
}

std::string SweepPlan::label(std::size_t setting) const {
  if (keys.empty()) {
    return "as configured";
  }
  std::vector<std::string> parts;
  parts.reserve(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    parts.push_back(keys[i] + "=" + settings[setting].values[i]);
  }
  return fmt::format("{}", fmt::join(parts, " "));
}

Result<SweepPlan> read_sweep(std::string_view toml, const std::string& name, const Vocabulary& vocabulary) {
  const Result<toml::table> root = parse_toml(toml, name);
  return root ? SweepReader(name, vocabulary).read(*root) : tl::unexpected(root.error());
}

Result<SweepPlan> load_sweep(const std::string& path, const Vocabulary& vocabulary) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file.is_open() || file.bad()) {
    return bad_input(fmt::format("{}: cannot be read: {}", path, std::strerror(errno)));
  }
  if (text.size() > kMaxSweepBytes) {
    return bad_input(fmt::format("{}: {} bytes: expected at most {}", path, text.size(), kMaxSweepBytes));
  }
  return read_sweep(text, path, vocabulary);
}

}  // namespace coppice
