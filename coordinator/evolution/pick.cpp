#include "coordinator/evolution/pick.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <system_error>

namespace coppice {
namespace {

constexpr std::string_view kFitness = "fitness";
constexpr std::string_view kElse = "else";
constexpr std::array<std::pair<std::string_view, Relation>, 3> kComparisons = {
    {{"<=", Relation::at_most}, {">=", Relation::at_least}, {"=", Relation::equal}}};

Result<std::optional<Measure>> measure_or_fitness(std::string_view name) {
  if (name == kFitness) {
    return std::optional<Measure>();
  }
  const auto measure = measure_named(name);
  if (!measure) {
    return bad_input(fmt::format("{}, {}", measure.error().message, kFitness));
  }
  return std::optional(*measure);
}

// Words are letters and underscores, signs of comparison, or anything else without blanks (numbers).
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) { next(); }

  const std::string_view& word() const { return word_; }
  bool at_end() const { return word_.empty(); }

  void next() {
    const std::size_t begin = text_.find_first_not_of(" \t");
    text_.remove_prefix(begin == std::string_view::npos ? text_.size() : begin);
    std::size_t size = 0;
    const auto of_comparison = [&](std::size_t at) { return text_[at] == '<' || text_[at] == '>' || text_[at] == '='; };
    while (size < text_.size() && text_[size] != ' ' && text_[size] != '\t' &&
           of_comparison(size) == of_comparison(0)) {
      ++size;
    }
    word_ = text_.substr(0, size);
    text_.remove_prefix(size);
  }

  tl::unexpected<Error> expected(std::string_view what) const {
    return bad_input(fmt::format("{}: expected {}", at_end() ? "the rule ends" : fmt::format("'{}'", word_), what));
  }

 private:
  std::string_view text_;
  std::string_view word_;
};

Result<PickCondition> parse_condition(Words& words) {
  if (words.at_end()) {
    return words.expected("a condition, such as nodes<=20");
  }
  const auto measure = measure_or_fitness(words.word());
  if (!measure) {
    return tl::unexpected(measure.error());
  }
  words.next();
  const auto sign = std::find_if(kComparisons.begin(), kComparisons.end(),
                                 [&](const auto& known) { return known.first == words.word(); });
  if (sign == kComparisons.end()) {
    return words.expected("<=, >= or =");
  }
  words.next();
  double number = 0.0;
  const std::string_view word = words.word();
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (word.empty() || error != std::errc() || end != word.data() + word.size() || !std::isfinite(number)) {
    return words.expected("a number");
  }
  words.next();
  return PickCondition{*measure, sign->second, number};
}

bool holds(const PickCondition& condition, const Front& front, const FrontMember& member) {
  const auto value = value_of(front, member, condition.measure);
  if (!value) {
    return false;
  }
  switch (condition.comparison) {
    case Relation::at_most:
      return *value <= condition.number;
    case Relation::at_least:
      return *value >= condition.number;
    case Relation::equal:
      break;
  }
  return *value == condition.number;
}

// Up to "else" or the end.
Result<PickRule> parse_choice(Words& words) {
  PickRule rule;
  if (words.word() != "best") {
    return words.expected("a rule, such as 'best return with nodes<=20 and coverage>=0.8'");
  }
  words.next();
  if (words.at_end()) {
    return words.expected("a measure");
  }
  const auto best = measure_or_fitness(words.word());
  if (!best) {
    return tl::unexpected(best.error());
  }
  rule.best = *best;
  words.next();
  for (std::string_view link = "with"; !words.at_end() && words.word() != kElse; link = "and") {
    if (words.word() != link) {
      return words.expected(fmt::format("'{}', '{}', or the end", link, kElse));
    }
    words.next();
    const auto condition = parse_condition(words);
    if (!condition) {
      return tl::unexpected(condition.error());
    }
    rule.conditions.push_back(*condition);
  }
  return rule;
}

}  // namespace

Result<PickRule> parse_pick(std::string_view text) {
  Words words(text);
  Result<PickRule> rule = parse_choice(words);
  while (rule && !words.at_end()) {
    words.next();
    auto next = parse_choice(words);
    if (!next) {
      return next;
    }
    rule->otherwise.push_back(std::move(*next));
  }
  return rule;
}

std::optional<double> value_of(const Front& front, const FrontMember& member, std::optional<Measure> measure) {
  if (!measure) {
    return member.fitness;
  }
  const auto found = std::find(front.measures.begin(), front.measures.end(), *measure);
  if (found == front.measures.end()) {
    return std::nullopt;
  }
  return member.values[static_cast<std::size_t>(found - front.measures.begin())];
}

std::optional<std::size_t> pick(const Front& front, const PickRule& rule) {
  const double sign = rule.best && is_cost(*rule.best) ? -1.0 : 1.0;
  std::optional<std::size_t> chosen;
  for (std::size_t i = 0; i < front.members.size(); ++i) {
    const FrontMember& member = front.members[i];
    const auto value = value_of(front, member, rule.best);
    if (!value || !std::all_of(rule.conditions.begin(), rule.conditions.end(),
                               [&](const PickCondition& condition) { return holds(condition, front, member); })) {
      continue;
    }
    if (!chosen) {
      chosen = i;
      continue;
    }
    const FrontMember& rival = front.members[*chosen];
    const double of_member = sign * *value;
    const double of_rival = sign * *value_of(front, rival, rule.best);
    const bool better = of_member != of_rival             ? of_member > of_rival
                        : member.fitness != rival.fitness ? member.fitness > rival.fitness
                                                          : member.tree.size() < rival.tree.size();
    chosen = better ? i : *chosen;
  }
  for (std::size_t i = 0; !chosen && i < rule.otherwise.size(); ++i) {
    chosen = pick(front, rule.otherwise[i]);
  }
  return chosen;
}

}  // namespace coppice
