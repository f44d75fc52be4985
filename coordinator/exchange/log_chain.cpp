#include "coordinator/exchange/log_chain.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numeric>
#include <utility>

#include "coordinator/exchange/feature_scale.hpp"

namespace coppice {
namespace {

// Vocabulary and the states' features.
Result<void> make_features(CountedLog& log, const std::vector<FeatureWish>& wishes, ChainParts& parts) {
  LogCounter& counter = *log.counter;
  const std::size_t width = log.header.features.size();
  std::vector<std::string> names;
  names.reserve(width);
  for (std::size_t f = 0; f < width; ++f) {
    names.push_back(wishes[f].name.empty() ? log.header.features[f] : wishes[f].name);
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

Result<void> make_starts(const LogCounter& counter, const std::string& source, ChainParts& parts) {
  std::vector<StartShare> starts;
  std::uint64_t divisor = 0;
  std::uint64_t total = 0;
  for (const auto& [state, count] : counter.starts()) {
    starts.push_back({state, static_cast<std::uint32_t>(std::min<std::uint64_t>(count, UINT32_MAX))});
    divisor = std::gcd(divisor, count);
    total += count;
  }
  if (total >> 32U != 0) {
    return bad_input(fmt::format("{}: {} episodes: expected below 2^32", source, total));
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

// What add_end(state, filled) appends goes into the rows of states that end episodes, `each` entries a row; the other
// rows stay as they are. `values` is one of the arrays that row_begin points into.
template <typename AddEnd>
void fill_rows(const ChainParts& parts, std::size_t each, std::vector<std::uint32_t>& values, const AddEnd& add_end) {
  const std::size_t actions = parts.vocabulary.actions.size();
  std::vector<std::uint32_t> filled;
  filled.reserve(values.size() + parts.terminals.size() * actions * each);
  std::uint64_t copied = 0;
  for (const std::uint32_t state : parts.terminals) {
    const std::uint64_t begin = parts.row_begin[state * actions];
    filled.insert(filled.end(), values.begin() + static_cast<std::ptrdiff_t>(copied),
                  values.begin() + static_cast<std::ptrdiff_t>(begin));
    copied = begin;
    for (std::size_t action = 0; action < actions; ++action) {
      add_end(state, filled);
    }
  }
  filled.insert(filled.end(), values.begin() + static_cast<std::ptrdiff_t>(copied), values.end());
  values = std::move(filled);
}

}  // namespace

std::vector<FeatureWish> wishes_of(const SourceHeader& header, const ProblemFile& file) {
  std::vector<FeatureWish> wishes;
  for (const std::string& name : header.features) {
    const auto wish = file.features.find(name);
    wishes.push_back(wish == file.features.end() ? FeatureWish{} : wish->second);
  }
  return wishes;
}

Result<ChainParts> parts_of_log(CountedLog& log, const std::vector<FeatureWish>& wishes, const ProblemFile& file,
                                const std::string& source) {
  LogCounter& counter = *log.counter;
  counter.states().forget_index();
  ChainParts parts;
  if (auto ok = make_features(log, wishes, parts); !ok) {
    return tl::unexpected(ok.error());
  }
  std::vector<std::string> names;
  for (const std::string& name : log.actions) {
    const auto wish = file.actions.find(name);
    names.push_back(wish == file.actions.end() || wish->second.name.empty() ? name : wish->second.name);
  }
  parts.vocabulary.actions = legal_names(names, "a");
  const std::size_t states = counter.states().size();
  for (std::uint32_t state = 0; state < states; ++state) {
    if (counter.states().codes(state).back() != 0) {
      parts.terminals.push_back(state);
    }
  }
  if (auto ok = make_starts(counter, source, parts); !ok) {
    return tl::unexpected(ok.error());
  }
  const std::size_t rows = states * names.size();
  parts.reward_sum = counter.take_reward_sum();
  parts.reward_sum.resize(rows, 0.0);
  parts.reward_sum.shrink_to_fit();
  if (file.collision_reward) {
    parts.collisions = counter.take_collisions();
    parts.collisions.resize(rows, 0);
    parts.collisions.shrink_to_fit();
  }
  if (auto ok = counter.counts().move_to(states, parts); !ok) {
    return tl::unexpected(ok.error());
  }
  log.counter.reset();
  return parts;
}

void fill_ends(WhenTerminal terminal, ChainParts& parts) {
  if (parts.terminals.empty()) {
    return;
  }
  std::vector<StartShare> starts = parts.starts;
  if (starts.empty()) {
    starts.push_back({parts.initial_state, 1});
  }
  const bool stays = terminal == WhenTerminal::absorb;
  // One array after the other, so that no two of them are there twice.
  fill_rows(parts, stays ? 1 : starts.size(), parts.count, [&](std::uint32_t, std::vector<std::uint32_t>& count) {
    for (std::size_t i = 0; i < (stays ? 1 : starts.size()); ++i) {
      count.push_back(stays ? 1 : starts[i].count);
    }
  });
  fill_rows(parts, stays ? 1 : starts.size(), parts.successor,
            [&](std::uint32_t state, std::vector<std::uint32_t>& successor) {
              for (std::size_t i = 0; i < (stays ? 1 : starts.size()); ++i) {
                successor.push_back(stays ? state : starts[i].state);
              }
            });
  const std::size_t actions = parts.vocabulary.actions.size();
  std::uint64_t added = 0;
  auto next_end = parts.terminals.begin();
  for (std::size_t row = 0; row + 1 < parts.row_begin.size(); ++row) {
    next_end += next_end != parts.terminals.end() && *next_end < row / actions ? 1 : 0;
    added += next_end != parts.terminals.end() && *next_end == row / actions ? (stays ? 1 : starts.size()) : 0;
    parts.row_begin[row + 1] += added;
  }
}

Result<NoAction> no_action_of(const ProblemFile& file, const std::vector<std::string>& actions) {
  if (file.no_action == "hold") {
    return NoAction{};
  }
  if (file.no_action == "worst") {
    return NoAction{NoAction::Kind::worst, ActionId{0}};
  }
  const auto found = std::find(actions.begin(), actions.end(), file.no_action);
  if (found == actions.end()) {
    return bad_input(fmt::format("no_action is '{}': expected hold, worst or an action ({})", file.no_action,
                                 fmt::join(actions, ", ")));
  }
  return NoAction{NoAction::Kind::named, ActionId{static_cast<std::uint8_t>(found - actions.begin())}};
}

Result<Problem> problem_of_log(const CountedLog& log, const std::vector<FeatureWish>& wishes, const ProblemFile& file,
                               const Vocabulary& vocabulary, const std::optional<double>& discount) {
  Problem problem = unlabelled(vocabulary);
  problem.title = file.title.substr(0, kMaxLabel);
  problem.simulator = file.simulator;
  problem.discount = discount;
  for (std::size_t f = 0; f < wishes.size(); ++f) {
    auto legend = legend_of(vocabulary.features[f], wishes[f]);
    if (!legend) {
      return tl::unexpected(legend.error());
    }
    problem.features[f] = std::move(*legend);
    if (problem.features[f].label.empty() && vocabulary.features[f].name != log.header.features[f]) {
      problem.features[f].label = log.header.features[f].substr(0, kMaxLabel);
    }
  }
  for (std::size_t a = 0; a < log.actions.size(); ++a) {
    const auto wish = file.actions.find(log.actions[a]);
    const bool labelled = wish != file.actions.end() && !wish->second.label.empty();
    problem.action_labels[a] =
        labelled ? wish->second.label.substr(0, kMaxLabel)
                 : (vocabulary.actions[a] != log.actions[a] ? log.actions[a].substr(0, kMaxLabel) : "");
  }
  return problem;
}

}  // namespace coppice
