#include "coordinator/exchange/log_passes.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <utility>

#include "common/chain/random.hpp"
#include "coordinator/exchange/binning.hpp"
#include "coordinator/exchange/feature_scale.hpp"
#include "coordinator/exchange/log_reader.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

constexpr std::uint64_t kStepsPerLook = 65536;  // between two looks at the clock

Result<std::unique_ptr<LogReader>> open_log(const std::string& path, SourceFormat format) {
  return format == SourceFormat::csv_log ? open_csv_log(path) : open_json_log(path);
}

// Steps kept to make bins from: all of a short log, else an even sample (Vitter's algorithm R, ACM TOMS 1985).
struct Sample {
  std::size_t width = 0;
  std::vector<double> readings;      // [steps x features]
  std::vector<std::uint8_t> action;  // [steps]
};

class LogPasses {
 public:
  LogPasses(const ImportSettings& settings, SourceFormat format, ProblemFile& file, const ImportProgress& go_on)
      : settings_(settings), file_(file), format_(format), go_on_(go_on) {}

  Result<CountedLog> run() {
    if (auto ok = look_at_head(); !ok) {
      return tl::unexpected(ok.error());
    }
    auto counter = count_all();
    if (!counter) {
      return tl::unexpected(counter.error());
    }
    return CountedLog{std::move(*counter), header_, action_names()};
  }

 private:
  // Calls step(step, log) for each line, until it says no. Errors: of the log, of step; interrupted.
  using EachStep = std::function<Result<bool>(const LogStep&, const LogReader&)>;
  Result<void> pass(std::string_view what, const EachStep& each) {
    if (++passes_ > kMaxPasses) {
      return bad_input(fmt::format("{}: not counted after {} passes", settings_.source, kMaxPasses));
    }
    auto log = open_log(settings_.source, format_);
    if (!log) {
      return tl::unexpected(log.error());
    }
    LogStep step;
    for (std::uint64_t steps = 0;; ++steps) {
      const auto more = (*log)->next(step);
      if (!more) {
        return tl::unexpected(more.error());
      }
      if (!*more) {
        header_ = (*log)->header();
        return {};
      }
      const auto go_on = each(step, **log);
      if (!go_on) {
        return tl::unexpected(go_on.error());
      }
      if (!*go_on) {
        header_ = (*log)->header();
        return {};
      }
      if (go_on_ && steps % kStepsPerLook == 0 &&
          !go_on_(what, static_cast<double>((*log)->lines().bytes_read()) /
                            static_cast<double>(std::max<std::uint64_t>((*log)->lines().size(), 1)))) {
        return tl::unexpected(Error{ErrorKind::interrupted, "importing was stopped"});
      }
    }
  }

  Result<void> look_at_head() {
    std::uint64_t steps = 0;
    auto ok = pass("looking at", [&](const LogStep& step, const LogReader& log) -> Result<bool> {
      if (distinct_.empty()) {
        distinct_.resize(log.features().size());
        fraction_.assign(log.features().size(), false);
      }
      for (std::size_t f = 0; f < distinct_.size(); ++f) {
        note_reading(f, step.observation[f]);
        if (!step.next.empty()) {
          note_reading(f, step.next[f]);
        }
      }
      if (std::find(seen_actions_.begin(), seen_actions_.end(), step.action) == seen_actions_.end()) {
        seen_actions_.emplace_back(step.action);
        if (seen_actions_.size() > kMaxActions) {
          return bad_input(fmt::format("{}: more than {} actions", log.lines().where(), kMaxActions));
        }
      }
      return ++steps < kLogSample;
    });
    if (!ok) {
      return ok;
    }
    if (steps == 0) {
      return bad_input(fmt::format("{}: no steps: expected a log of transitions", settings_.source));
    }
    fill_from_header(header_, file_);
    for (const auto& [name, wish] : file_.features) {
      if (std::find(header_.features.begin(), header_.features.end(), name) == header_.features.end()) {
        return bad_input(fmt::format("features.{}: no such feature in the log: expected one of ({})", name,
                                     fmt::join(header_.features, ", ")));
      }
    }
    needs_bins_.assign(distinct_.size(), false);
    for (std::size_t f = 0; f < distinct_.size(); ++f) {
      const auto wish = file_.features.find(header_.features[f]);
      const bool asked = wish != file_.features.end() && wish->second.binning;
      needs_bins_[f] = asked ? wish->second.binning->kind != Binning::Kind::none : has_too_many(f);
    }
    return {};
  }

  void note_reading(std::size_t feature, double reading) {
    distinct_[feature].add(reading);
    fraction_[feature] = fraction_[feature] || reading != std::floor(reading);
  }

  bool has_too_many(std::size_t f) const {
    return distinct_[f].too_many() || (fraction_[f] && distinct_[f].values().size() > kFewReadings);
  }

  // The actions by index: as the header names them, in the order of their numbers, or of first sight.
  std::vector<std::string> actions() const {
    std::vector<std::string> names = seen_actions_;
    const bool numbers =
        std::all_of(names.begin(), names.end(), [](const std::string& name) { return to_double(name).has_value(); });
    if (numbers) {
      std::sort(names.begin(), names.end(),
                [](const std::string& a, const std::string& b) { return *to_double(a) < *to_double(b); });
    }
    return names;
  }

  Result<Sample> sample() {
    Sample sample;
    const std::vector<std::string> names = actions();
    Xoshiro256 random(1);
    std::uint64_t steps = 0;
    auto ok = pass("sampling", [&](const LogStep& step, const LogReader&) -> Result<bool> {
      const auto action = static_cast<std::uint8_t>(std::find(names.begin(), names.end(), step.action) - names.begin());
      sample.width = step.observation.size();
      if (steps < kLogSample) {
        sample.readings.insert(sample.readings.end(), step.observation.begin(), step.observation.end());
        sample.action.push_back(action);
      } else if (const std::uint64_t at = random.below(steps + 1); at < kLogSample) {
        std::copy(step.observation.begin(), step.observation.end(),
                  sample.readings.begin() + static_cast<std::ptrdiff_t>(at * sample.width));
        sample.action[at] = action;
      }
      ++steps;
      return true;
    });
    return ok ? Result<Sample>(std::move(sample)) : tl::unexpected(ok.error());
  }

  Result<std::vector<std::vector<double>>> edges() {
    std::vector<std::vector<double>> edges(distinct_.size());
    std::optional<Sample> readings;
    for (std::size_t f = 0; f < edges.size(); ++f) {
      if (!needs_bins_[f]) {
        continue;
      }
      const auto wish = file_.features.find(header_.features[f]);
      const bool asked = wish != file_.features.end() && wish->second.binning;
      const Binning binning =
          asked ? *wish->second.binning : Binning{.kind = Binning::Kind::entropy, .edges = {}, .bins = kDefaultBins};
      if (binning.kind == Binning::Kind::edges) {
        auto given = given_edges(binning.edges);
        if (!given) {
          return in_context(fmt::format("features.{}.bins", header_.features[f]), given.error());
        }
        edges[f] = std::move(*given);
        continue;
      }
      if (!readings) {
        auto sampled = sample();
        if (!sampled) {
          return tl::unexpected(sampled.error());
        }
        readings = std::move(*sampled);
      }
      std::vector<ClassedReading> classed;
      classed.reserve(readings->action.size());
      for (std::size_t i = 0; i < readings->action.size(); ++i) {
        classed.push_back({readings->readings[i * readings->width + f], readings->action[i], 1.0});
      }
      edges[f] = binning.kind == Binning::Kind::quantiles ? quantile_edges(std::move(classed), binning.bins)
                                                          : entropy_edges(std::move(classed), binning.bins, true);
      if (edges[f].empty()) {  // one reading only, so far
        edges[f].push_back(readings->readings[f]);
      }
    }
    return edges;
  }

  // Ends: each further pass knows an action more, or bins of a feature more.
  Result<std::unique_ptr<LogCounter>> count_all() {
    while (true) {
      LogCounterSettings settings{{}, actions(), file_.collision_reward};
      auto cut = edges();
      if (!cut) {
        return tl::unexpected(cut.error());
      }
      settings.edges = std::move(*cut);
      auto counter = std::make_unique<LogCounter>(settings);
      auto obstacle = LogCounter::Obstacle::none;
      auto ok = pass("counting", [&](const LogStep& step, const LogReader& log) -> Result<bool> {
        const auto added = counter->add(step, log);
        if (!added) {
          return tl::unexpected(added.error());
        }
        obstacle = *added;
        return obstacle == LogCounter::Obstacle::none;
      });
      if (!ok) {
        return tl::unexpected(ok.error());
      }
      if (obstacle == LogCounter::Obstacle::none) {
        counter->finish();
        return counter;
      }
      if (obstacle == LogCounter::Obstacle::new_action) {
        seen_actions_.push_back(counter->obstacle_action());
        if (seen_actions_.size() > kMaxActions) {
          return bad_input(fmt::format("{}: more than {} actions", settings_.source, kMaxActions));
        }
      } else {
        needs_bins_[counter->obstacle_feature()] = true;
      }
    }
  }

  // The names of actions: a number is an index into the header's names.
  std::vector<std::string> action_names() const {
    std::vector<std::string> names;
    for (const std::string& action : actions()) {
      const auto index = to_whole(action);
      const bool named = index && *index < header_.actions.size();
      names.push_back(named ? header_.actions[*index] : action);
    }
    return names;
  }

  const ImportSettings& settings_;
  ProblemFile& file_;
  SourceFormat format_;
  const ImportProgress& go_on_;
  SourceHeader header_;
  std::size_t passes_ = 0;
  std::vector<DistinctReadings> distinct_;  // [features], of the head
  std::vector<bool> fraction_;              // [features], whether some reading is not whole
  std::vector<bool> needs_bins_;            // [features]
  std::vector<std::string> seen_actions_;   // as written, in the order of first sight
};

}  // namespace

Result<CountedLog> count_log(const ImportSettings& settings, SourceFormat format, ProblemFile& file,
                             const ImportProgress& go_on) {
  return LogPasses(settings, format, file, go_on).run();
}

}  // namespace coppice
