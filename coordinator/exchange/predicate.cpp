#include "coordinator/exchange/predicate.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <utility>

#include "coordinator/exchange/text_number.hpp"

namespace coppice {

Result<Predicate> Predicate::parse(std::string_view text, const std::vector<std::string>& features) {
  constexpr std::array<std::pair<std::string_view, Op>, 6> kOps{{{"!=", Op::unequal},
                                                                 {"<=", Op::less_equal},
                                                                 {">=", Op::greater_equal},
                                                                 {"=", Op::equal},
                                                                 {"<", Op::less},
                                                                 {">", Op::greater}}};
  if (text.size() > kMaxPredicate) {
    return bad_input(fmt::format("a test of {} characters: expected at most {}", text.size(), kMaxPredicate));
  }
  Predicate predicate;
  predicate.any_of_.emplace_back();
  std::size_t at = 0;
  const auto skip = [&] {
    while (at < text.size() && is_text_blank(text[at])) {
      ++at;
    }
  };
  const auto take_until = [&](std::string_view ends) {
    skip();
    const std::size_t begin = at;
    at = std::min(text.find_first_of(ends, at), text.size());
    return trimmed(text.substr(begin, at - begin));
  };
  while (true) {  // ends: every turn takes a test
    skip();
    const std::size_t column = at + 1;
    const std::string_view name = take_until("=!<>");
    const auto feature = std::find(features.begin(), features.end(), name);
    if (feature == features.end()) {
      return bad_input(
          fmt::format("column {}: found '{}': expected a feature ({})", column, name, fmt::join(features, ", ")));
    }
    const auto* op = std::find_if(kOps.begin(), kOps.end(), [&](const auto& candidate) {
      return text.substr(at, candidate.first.size()) == candidate.first;
    });
    if (op == kOps.end()) {
      return bad_input(fmt::format("column {}: expected =, !=, <, <=, > or >= behind '{}'", at + 1, name));
    }
    at += op->first.size();
    skip();
    const std::size_t number_column = at + 1;
    const std::string_view number_text = take_until(" \t");
    const auto number = to_double(number_text);
    if (!number) {
      return bad_input(fmt::format("column {}: found '{}': expected a number", number_column, number_text));
    }
    predicate.any_of_.back().push_back({static_cast<std::size_t>(feature - features.begin()), op->second, *number});
    skip();
    if (at == text.size()) {
      return predicate;
    }
    const std::size_t word_column = at + 1;
    const std::string_view word = take_until(" \t");
    if (word != "and" && word != "or") {
      return bad_input(fmt::format("column {}: found '{}': expected 'and', 'or' or the end", word_column, word));
    }
    if (word == "or") {
      predicate.any_of_.emplace_back();
    }
  }
}

bool Predicate::compares(double reading, const Test& test) {
  switch (test.op) {
    case Op::equal:
      return reading == test.number;
    case Op::unequal:
      return reading != test.number;
    case Op::less:
      return reading < test.number;
    case Op::less_equal:
      return reading <= test.number;
    case Op::greater:
      return reading > test.number;
    case Op::greater_equal:
      break;
  }
  return reading >= test.number;
}

bool Predicate::holds(std::span<const double> readings) const {
  return std::any_of(any_of_.begin(), any_of_.end(), [&](const std::vector<Test>& all) {
    return std::all_of(all.begin(), all.end(),
                       [&](const Test& test) { return compares(readings[test.feature], test); });
  });
}

}  // namespace coppice
