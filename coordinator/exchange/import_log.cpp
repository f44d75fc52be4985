#include "coordinator/exchange/import_log.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>

#include "common/chain/random.hpp"
#include "common/check.hpp"
#include "coordinator/exchange/binning.hpp"
#include "coordinator/exchange/feature_scale.hpp"
#include "coordinator/exchange/given_policy.hpp"
#include "coordinator/exchange/log_counter.hpp"
#include "coordinator/exchange/log_reader.hpp"
#include "coordinator/exchange/predicate.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

constexpr std::uint64_t kStepsPerLook = 65536;  // between two looks at the clock
constexpr double kUsualDiscount = 0.99;         // where nobody said one

Result<std::unique_ptr<LogReader>> open_log(const std::string& path, SourceFormat format) {
  return format == SourceFormat::csv_log ? open_csv_log(path) : open_json_log(path);
}

// Steps kept to make bins from: all of a short log, else an even sample (Vitter's algorithm R, ACM TOMS 1985).
struct Sample {
  std::size_t width = 0;
  std::vector<double> readings;      // [steps x features]
  std::vector<std::uint8_t> action;  // [steps]
};

class LogImport {
 public:
  LogImport(const ImportSettings& settings, SourceFormat format, const ImportProgress& go_on)
      : settings_(settings), file_(settings.problem), format_(format), go_on_(go_on) {}

  Result<Imported> run() {
    if (auto ok = check_flags(); !ok) {
      return tl::unexpected(ok.error());
    }
    if (auto ok = look_at_head(); !ok) {
      return tl::unexpected(ok.error());
    }
    auto counter = count_all();
    if (!counter) {
      return tl::unexpected(counter.error());
    }
    return make(std::move(*counter));
  }

 private:
  Result<void> check_flags() const {
    const bool given = !settings_.q.empty() || !settings_.policy.empty();
    if (settings_.solve && given) {
      return bad_input("--solve makes Q-values and policy: expected it without --q and --policy");
    }
    if (!file_.without_actions.empty() || file_.look_alikes == LookAlikes::merge) {
      return bad_input(
          "a log's states are what is observed, and its actions what was done: expected no action to leave "
          "out and nothing to merge");
    }
    if (!file_.collisions.label.empty() || !file_.collisions.shares.empty() || !file_.terminals.empty() ||
        !file_.initial.empty()) {
      return bad_input(
          "a log says itself where episodes start and end, and its states have no labels or numbers: expected "
          "collisions "
          "by reward or test, and no terminals or initial states");
    }
    return {};
  }

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

  Result<Imported> make(std::unique_ptr<LogCounter> counted) {
    LogCounter& counter = *counted;
    counter.states().forget_index();
    ImportReport report;
    report.format = name_of(format_);
    report.steps = counter.steps();
    report.episodes = counter.episodes();
    report.truncated = counter.truncated();
    if (counter.unfinished() > 0) {
      report.notes.push_back(
          fmt::format("Of {} of the steps the log does not say where they led: not counted.", counter.unfinished()));
    }
    ChainParts parts;
    std::vector<FeatureWish> wishes;
    if (auto ok = make_features(counter, parts, wishes); !ok) {
      return tl::unexpected(ok.error());
    }
    const std::vector<std::string> names = action_names();
    std::vector<std::string> wanted_names;
    for (const std::string& name : names) {
      const auto wish = file_.actions.find(name);
      wanted_names.push_back(wish == file_.actions.end() || wish->second.name.empty() ? name : wish->second.name);
    }
    parts.vocabulary.actions = legal_names(wanted_names, "a");
    const std::size_t states = counter.states().size();
    if (auto ok = counter.counts().move_to(states, parts); !ok) {
      return tl::unexpected(ok.error());
    }
    const std::size_t rows = states * names.size();
    parts.reward_sum = counter.take_reward_sum();
    parts.reward_sum.resize(rows, 0.0);
    if (file_.collision_reward) {
      parts.collisions = counter.take_collisions();
      parts.collisions.resize(rows, 0);
    }
    for (std::uint32_t state = 0; state < states; ++state) {
      if (counter.states().codes(state).back() != 0) {
        parts.terminals.push_back(state);
      }
    }
    if (auto ok = make_starts(counter, parts); !ok) {
      return tl::unexpected(ok.error());
    }
    counted.reset();
    return finish(std::move(parts), names, wishes, std::move(report));
  }

  Result<void> make_features(LogCounter& counter, ChainParts& parts, std::vector<FeatureWish>& wishes) {
    const std::size_t width = header_.features.size();
    std::vector<std::string> names;
    for (const std::string& name : header_.features) {
      const auto wish = file_.features.find(name);
      wishes.push_back(wish == file_.features.end() ? FeatureWish{} : wish->second);
      names.push_back(wishes.back().name.empty() ? name : wishes.back().name);
    }
    names = legal_names(names, "f");
    std::vector<std::vector<std::uint8_t>> value_of_code(width);
    for (std::size_t f = 0; f < width; ++f) {
      const ReadingCodes& codes = counter.codes()[f];
      DistinctReadings distinct;
      for (const double reading : codes.readings()) {
        distinct.add(reading);
      }
      FeatureWish wish = wishes[f];
      wish.binning =
          codes.binned() ? std::optional(Binning{.kind = Binning::Kind::edges, .edges = {}, .bins = 0}) : std::nullopt;
      auto feature = feature_of(names[f], distinct, wish, {},
                                [&codes](const Binning&) { return Result<std::vector<double>>(codes.edges()); });
      if (!feature) {
        return tl::unexpected(feature.error());
      }
      for (std::size_t code = 0; code < (codes.binned() ? codes.edges().size() + 1 : codes.readings().size()); ++code) {
        value_of_code[f].push_back(codes.binned() ? static_cast<std::uint8_t>(code)
                                                  : *feature->value_of(codes.readings()[code]));
      }
      parts.vocabulary.features.push_back(std::move(*feature));
    }
    parts.features.reserve(counter.states().size() * width);
    for (std::size_t state = 0; state < counter.states().size(); ++state) {
      const auto codes = counter.states().codes(state);
      for (std::size_t f = 0; f < width; ++f) {
        parts.features.push_back(value_of_code[f][codes[f]]);
      }
    }
    return {};
  }

  Result<void> make_starts(const LogCounter& counter, ChainParts& parts) const {
    std::vector<StartShare> starts;
    std::uint64_t divisor = 0;
    std::uint64_t total = 0;
    for (const auto& [state, count] : counter.starts()) {
      starts.push_back({state, static_cast<std::uint32_t>(std::min<std::uint64_t>(count, UINT32_MAX))});
      divisor = std::gcd(divisor, count);
      total += count;
    }
    if (total >> 32U != 0) {
      return bad_input(fmt::format("{}: {} episodes: expected below 2^32", settings_.source, total));
    }
    std::sort(starts.begin(), starts.end(), [](const StartShare& a, const StartShare& b) { return a.state < b.state; });
    for (StartShare& start : starts) {
      start.count = static_cast<std::uint32_t>(start.count / std::max<std::uint64_t>(divisor, 1));
    }
    parts.initial_state = starts.front().state;
    if (starts.size() > 1) {
      parts.starts = std::move(starts);
    }
    return {};
  }

  // The counts as a model: terminal states have no rows yet, untried pairs none at all. Takes row_begin and successor
  // out of `parts`, which gets them back from give_back(): a log's chain should not be in memory twice.
  static Model model_of(ChainParts& parts, const std::vector<std::string>& features,
                        const std::vector<std::string>& actions, bool with_readings) {
    Model model;
    model.action_names = actions;
    model.probability.resize(parts.count.size());
    model.reward.assign(parts.reward_sum.size(), 0.0);
    for (std::size_t row = 0; row + 1 < parts.row_begin.size(); ++row) {
      double tries = 0.0;
      for (std::uint64_t i = parts.row_begin[row]; i < parts.row_begin[row + 1]; ++i) {
        tries += parts.count[i];
      }
      for (std::uint64_t i = parts.row_begin[row]; i < parts.row_begin[row + 1]; ++i) {
        model.probability[i] = parts.count[i] / tries;
      }
      model.reward[row] = tries > 0.0 ? parts.reward_sum[row] / tries : 0.0;
    }
    model.row_begin = std::move(parts.row_begin);
    model.successor = std::move(parts.successor);
    model.terminals = parts.terminals;
    double total = 0.0;
    for (const StartShare& start : parts.starts) {
      total += start.count;
    }
    model.starts.push_back({parts.initial_state, 1.0});
    if (!parts.starts.empty()) {
      model.starts.clear();
      for (const StartShare& start : parts.starts) {
        model.starts.push_back({start.state, start.count / total});
      }
    }
    const std::size_t width = features.size();
    if (!with_readings) {
      model.feature_names = {"state"};
      model.readings.assign(parts.features.size() / width, 0.0);
      return model;
    }
    model.feature_names = features;
    model.readings.reserve(parts.features.size());
    for (std::size_t i = 0; i < parts.features.size(); ++i) {
      const Feature& feature = parts.vocabulary.features[i % width];
      const auto place = static_cast<std::size_t>(
          std::lower_bound(feature.values.begin(), feature.values.end(), parts.features[i]) - feature.values.begin());
      // Of a bin its upper edge, and of the last its lower one: any number in order does.
      model.readings.push_back(feature.scale == Scale::plain
                                   ? static_cast<double>(parts.features[i])
                                   : feature.numbers[std::min(place, feature.numbers.size() - 1)]);
    }
    return model;
  }

  static void give_back(Model& model, ChainParts& parts) {
    parts.row_begin = std::move(model.row_begin);
    parts.successor = std::move(model.successor);
  }

  Result<Imported> finish(ChainParts parts, const std::vector<std::string>& actions,
                          const std::vector<FeatureWish>& wishes, ImportReport report) {
    const std::size_t states = parts.visits.empty() ? parts.features.size() / header_.features.size() : 0;
    const std::size_t count = actions.size();
    std::vector<std::uint64_t> tries(states * count, 0);
    for (std::size_t row = 0; row < tries.size(); ++row) {
      for (std::uint64_t i = parts.row_begin[row]; i < parts.row_begin[row + 1]; ++i) {
        tries[row] += parts.count[i];
      }
    }
    SolveSettings solving;
    const std::optional<double> said = settings_.gamma ? settings_.gamma : file_.discount;
    solving.horizon = settings_.horizon;
    solving.gamma = said.value_or(settings_.horizon ? 1.0 : kUsualDiscount);
    if (auto ok = check_settings(solving); !ok) {
      return tl::unexpected(ok.error());
    }
    if (!said && !settings_.horizon && settings_.q.empty()) {
      report.notes.push_back(fmt::format("Nobody said a discount (--gamma): {} is taken.", kUsualDiscount));
    }
    const auto during = [this](std::string_view what) -> SolveProgress {
      return go_on_ ? SolveProgress([this, what](double share) { return go_on_(what, share); }) : SolveProgress();
    };
    {
      const bool with_readings = !settings_.q.empty() || !settings_.policy.empty() || !file_.collisions.when.empty();
      Model model = model_of(parts, header_.features, actions, with_readings);
      auto policy = policy_of(model, tries, solving, during("solving"), report);
      if (!policy) {
        return tl::unexpected(policy.error());
      }
      const auto value = value_of_policy(model, policy->policy, solving, during("valuing"));
      if (!value) {
        return tl::unexpected(value.error());
      }
      report.value = *value;
      report.count_error = 0.0;  // the counts are what the log holds
      if (auto ok = collide_by_test(model, parts); !ok) {
        return tl::unexpected(ok.error());
      }
      give_back(model, parts);
      parts.q = std::move(policy->q);
      parts.policy = std::move(policy->policy);
    }
    parts.visits.assign(states, 0);
    std::uint64_t other = 0;
    std::uint64_t all = 0;
    std::vector<bool> terminal(states, false);
    for (const std::uint32_t state : parts.terminals) {
      terminal[state] = true;
    }
    for (std::size_t state = 0; state < states; ++state) {
      const auto begin = tries.begin() + static_cast<std::ptrdiff_t>(state * count);
      const auto end = begin + static_cast<std::ptrdiff_t>(count);
      for (auto row = begin; row != end; ++row) {
        parts.visits[state] += *row;
        report.never_tried += *row == 0 && !terminal[state] ? 1 : 0;
      }
      report.contradictions += std::count_if(begin, end, [](std::uint64_t n) { return n > 0; }) > 1 ? 1 : 0;
      all += parts.visits[state];
      other += parts.visits[state] - *std::max_element(begin, end);
    }
    const bool binned = std::any_of(parts.vocabulary.features.begin(), parts.vocabulary.features.end(),
                                    [](const Feature& feature) { return feature.scale == Scale::bins; });
    if (binned && all > 0) {
      report.bin_disagreement = static_cast<double>(other) / static_cast<double>(all);
    }
    std::vector<std::uint64_t>().swap(tries);
    fill_ends(parts, count);
    if (auto ok = set_no_action(parts, actions); !ok) {
      return tl::unexpected(ok.error());
    }
    return finish_problem(std::move(parts), actions, wishes, std::move(report), said);
  }

  // What the log shows, solved, or given.
  Result<PolicyOfModel> policy_of(const Model& model, const std::vector<std::uint64_t>& tries,
                                  const SolveSettings& solving, const SolveProgress& go_on, ImportReport& report) {
    PolicyOfModel policy;
    if (settings_.solve) {
      auto solution = solve(model, solving, go_on);
      if (!solution) {
        return tl::unexpected(solution.error());
      }
      report.ties = solution->ties;
      report.sweeps = solution->sweeps;
      report.bound = solution->bound;
      return PolicyOfModel{std::move(solution->q), std::move(solution->policy), {}};
    }
    if (!settings_.q.empty() || !settings_.policy.empty()) {
      auto given = read_given_policy(settings_.q, settings_.policy, model);
      if (!given) {
        return tl::unexpected(given.error());
      }
      report.ties = given->ties;
      if (given->unlisted > 0) {
        report.notes.push_back(
            fmt::format("The table does not have {} of the states; the first action tried is taken "
                        "there.",
                        given->unlisted));
      }
      policy.policy = std::move(given->policy);
      policy.q = std::move(given->q);
    } else {
      const std::size_t count = model.actions();
      for (std::size_t first = 0; first < tries.size(); first += count) {
        const auto begin = tries.begin() + static_cast<std::ptrdiff_t>(first);
        const auto most = std::max_element(begin, begin + static_cast<std::ptrdiff_t>(count));
        report.ties += *most > 0 && std::count(begin, begin + static_cast<std::ptrdiff_t>(count), *most) > 1 ? 1 : 0;
        policy.policy.push_back(ActionId{static_cast<std::uint8_t>(most - begin)});
      }
    }
    if (policy.q.empty()) {
      const auto values = values_of_policy(model, policy.policy, solving, go_on);
      if (!values) {
        return tl::unexpected(values.error());
      }
      policy.q = q_of_values(model, *values, solving.gamma);
    }
    for (double& q : policy.q) {
      q = std::isnan(q) ? 0.0 : q;
    }
    return policy;
  }

  // A step that arrives where the problem file's test holds is a collision.
  Result<void> collide_by_test(const Model& model, ChainParts& parts) const {
    if (file_.collisions.when.empty()) {
      return {};
    }
    const auto predicate = Predicate::parse(file_.collisions.when, model.feature_names);
    if (!predicate) {
      return in_context("collisions.when", predicate.error());
    }
    parts.collisions.assign(model.rows(), 0);
    for (std::size_t row = 0; row < model.rows(); ++row) {
      for (std::uint64_t i = model.row_begin[row]; i < model.row_begin[row + 1]; ++i) {
        parts.collisions[row] += predicate->holds(model.readings_of(model.successor[i])) ? parts.count[i] : 0;
      }
    }
    return {};
  }

  // Terminal states' rows: they stay, or lead to the starts.
  void fill_ends(ChainParts& parts, std::size_t actions) const {
    if (parts.terminals.empty()) {
      return;
    }
    std::vector<StartShare> starts = parts.starts;
    if (starts.empty()) {
      starts.push_back({parts.initial_state, 1});
    }
    const std::size_t rows = parts.row_begin.size() - 1;
    std::vector<std::uint64_t> begin;
    begin.reserve(rows + 1);
    begin.push_back(0);
    std::vector<std::uint32_t> successor;
    std::vector<std::uint32_t> count;
    const std::size_t each = file_.terminal == WhenTerminal::absorb ? 1 : starts.size();
    successor.reserve(parts.successor.size() + parts.terminals.size() * actions * each);
    count.reserve(successor.capacity());
    auto next_end = parts.terminals.begin();
    for (std::size_t row = 0; row < rows; ++row) {
      const auto state = static_cast<std::uint32_t>(row / actions);
      while (next_end != parts.terminals.end() && *next_end < state) {
        ++next_end;
      }
      if (next_end == parts.terminals.end() || *next_end != state) {
        successor.insert(successor.end(), parts.successor.begin() + static_cast<std::ptrdiff_t>(parts.row_begin[row]),
                         parts.successor.begin() + static_cast<std::ptrdiff_t>(parts.row_begin[row + 1]));
        count.insert(count.end(), parts.count.begin() + static_cast<std::ptrdiff_t>(parts.row_begin[row]),
                     parts.count.begin() + static_cast<std::ptrdiff_t>(parts.row_begin[row + 1]));
      } else if (file_.terminal == WhenTerminal::absorb) {
        successor.push_back(state);
        count.push_back(1);
      } else {
        for (const StartShare& start : starts) {
          successor.push_back(start.state);
          count.push_back(start.count);
        }
      }
      begin.push_back(successor.size());
    }
    parts.row_begin = std::move(begin);
    parts.successor = std::move(successor);
    parts.count = std::move(count);
  }

  Result<void> set_no_action(ChainParts& parts, const std::vector<std::string>& actions) const {
    if (file_.no_action == "hold") {
      return {};
    }
    parts.no_action.kind = NoAction::Kind::worst;
    if (file_.no_action != "worst") {
      const auto found = std::find(actions.begin(), actions.end(), file_.no_action);
      if (found == actions.end()) {
        return bad_input(fmt::format("no_action is '{}': expected hold, worst or an action ({})", file_.no_action,
                                     fmt::join(actions, ", ")));
      }
      parts.no_action = {NoAction::Kind::named, ActionId{static_cast<std::uint8_t>(found - actions.begin())}};
    }
    return {};
  }

  Result<Imported> finish_problem(ChainParts parts, const std::vector<std::string>& actions,
                                  const std::vector<FeatureWish>& wishes, ImportReport report,
                                  const std::optional<double>& discount) {
    const std::size_t width = parts.vocabulary.features.size();
    // An end may read as a state that goes on.
    parts.look_alikes = !parts.terminals.empty();
    Problem problem = unlabelled(parts.vocabulary);
    problem.title = file_.title.substr(0, kMaxLabel);
    problem.simulator = file_.simulator;
    problem.discount = discount;
    problem.source =
        fmt::format("{} ({} log)", settings_.source, format_ == SourceFormat::csv_log ? "CSV" : "JSON lines");
    for (std::size_t f = 0; f < width; ++f) {
      auto legend = legend_of(parts.vocabulary.features[f], wishes[f]);
      if (!legend) {
        return tl::unexpected(legend.error());
      }
      problem.features[f] = std::move(*legend);
      if (problem.features[f].label.empty() && parts.vocabulary.features[f].name != header_.features[f]) {
        problem.features[f].label = header_.features[f].substr(0, kMaxLabel);
      }
    }
    for (std::size_t a = 0; a < actions.size(); ++a) {
      const auto wish = file_.actions.find(actions[a]);
      const bool labelled = wish != file_.actions.end() && !wish->second.label.empty();
      problem.action_labels[a] =
          labelled ? wish->second.label.substr(0, kMaxLabel)
                   : (parts.vocabulary.actions[a] != actions[a] ? actions[a].substr(0, kMaxLabel) : "");
    }
    auto chain = Chain::make(std::move(parts));
    if (!chain) {
      return tl::unexpected(chain.error());
    }
    return Imported{std::move(*chain), std::move(problem), std::move(report)};
  }

  const ImportSettings& settings_;
  ProblemFile file_;
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

Result<Imported> import_log(const ImportSettings& settings, SourceFormat format, const ImportProgress& go_on) {
  COPPICE_CHECK(format == SourceFormat::csv_log || format == SourceFormat::json_log);
  return LogImport(settings, format, go_on).run();
}

}  // namespace coppice
