#include "coordinator/trust/rule.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <fmt/format.h>
#include <fstream>
#include <optional>
#include <system_error>

namespace coppice {
namespace {

constexpr std::string_view kNone = "none";

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

struct Token {
  enum class Kind : std::uint8_t { word, number, comparison, foreign, end };
  Kind kind = Kind::end;
  std::string_view text;
  std::size_t column = 1;
};

class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) { advance(); }

  const Token& now() const { return now_; }

  void advance() {
    while (at_ < text_.size() && is_blank(text_[at_])) {
      ++at_;
    }
    const std::size_t begin = at_;
    now_ = {Token::Kind::end, {}, begin + 1};
    if (begin == text_.size()) {
      return;
    }
    const char first = text_[begin];
    const auto take_while = [&](const auto& wanted) {
      while (at_ < text_.size() && wanted(text_[at_])) {
        ++at_;
      }
    };
    if (is_letter(first)) {
      take_while([](char c) { return is_letter(c) || is_digit(c); });
      now_.kind = Token::Kind::word;
    } else if (is_digit(first) || first == '-' || first == '.') {
      take_while([](char c) { return is_digit(c) || c == '-' || c == '.' || c == 'e' || c == '+'; });
      now_.kind = Token::Kind::number;
    } else if (first == '=' || first == '<' || first == '>' || first == '!') {
      ++at_;
      at_ += at_ < text_.size() && text_[at_] == '=' && first != '=' ? 1U : 0U;
      now_.kind = text_.substr(begin, at_ - begin) == "!" ? Token::Kind::foreign : Token::Kind::comparison;
    } else {
      ++at_;
      now_.kind = Token::Kind::foreign;
    }
    now_.text = text_.substr(begin, at_ - begin);
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  Token now_;
};

std::string found(const Token& token) {
  if (token.kind == Token::Kind::end) {
    return "the end";
  }
  constexpr std::size_t kShown = 40;
  return fmt::format("'{}'{}", token.text.substr(0, kShown), token.text.size() > kShown ? "..." : "");
}

tl::unexpected<Error> wrong(const Token& token, const std::string& expected) {
  return bad_input(fmt::format("column {}: found {}, expected {}", token.column, found(token), expected));
}

bool compares(std::uint8_t value, std::string_view op, unsigned bound) {
  if (op == "=") {
    return value == bound;
  }
  if (op == "!=") {
    return value != bound;
  }
  if (op == "<=") {
    return value <= bound;
  }
  if (op == "<") {
    return value < bound;
  }
  return op == ">=" ? value >= bound : value > bound;
}

std::vector<ValueSet> anything(const Vocabulary& vocabulary) {
  std::vector<ValueSet> all(vocabulary.features.size());
  for (std::size_t f = 0; f < all.size(); ++f) {
    for (const std::uint8_t value : vocabulary.features[f].values) {
      all[f].set(value);
    }
  }
  return all;
}

class Parser {
 public:
  Parser(std::string_view text, const Vocabulary& vocabulary)
      : tokens_(text), vocabulary_(vocabulary), rule_{.text = std::string(text), .actions = {}, .when = {}} {}

  Result<Rule> parse() {
    const Token first = tokens_.now();
    if (first.text != "never" && first.text != "always") {
      return wrong(first, "'never' or 'always'");
    }
    rule_.always = first.text == "always";
    do {  // ends: every turn consumes an action
      tokens_.advance();
      if (const Result<void> read = read_action(); !read) {
        return tl::unexpected(read.error());
      }
    } while (tokens_.now().text == "or");
    if (tokens_.now().kind == Token::Kind::end) {
      rule_.when.push_back(anything(vocabulary_));
      return std::move(rule_);
    }
    if (tokens_.now().text != "when") {
      return wrong(tokens_.now(), "'or', 'when' or the end");
    }
    do {
      if (const Result<void> read = read_all(); !read) {
        return tl::unexpected(read.error());
      }
    } while (tokens_.now().text == "or");
    if (tokens_.now().kind != Token::Kind::end) {
      return wrong(tokens_.now(), "'and', 'or' or the end");
    }
    return std::move(rule_);
  }

 private:
  Result<void> read_action() {
    const Token token = tokens_.now();
    const std::optional<ActionId> action = vocabulary_.find_action(token.text);
    if (!action && token.text != kNone) {
      return wrong(token, fmt::format("an action ({}, or none)", fmt::join(vocabulary_.actions, ", ")));
    }
    rule_.actions.push_back(action.value_or(kNoAction));
    tokens_.advance();
    return {};
  }

  // Tests joined by "and"; the word before them is the current token.
  Result<void> read_all() {
    const Token start = tokens_.now();
    std::vector<ValueSet> allowed = anything(vocabulary_);
    do {
      tokens_.advance();
      if (const Result<void> read = read_test(allowed); !read) {
        return read;
      }
    } while (tokens_.now().text == "and");
    for (std::size_t f = 0; f < allowed.size(); ++f) {
      if (allowed[f].none()) {
        return bad_input(fmt::format("column {}: no observation meets the tests of {} behind '{}'", start.column,
                                     vocabulary_.features[f].name, start.text));
      }
    }
    rule_.when.push_back(std::move(allowed));
    return {};
  }

  Result<void> read_test(std::vector<ValueSet>& allowed) {
    const Token name = tokens_.now();
    const std::optional<std::size_t> feature = vocabulary_.find_feature(name.text);
    if (!feature) {
      std::vector<std::string_view> names;
      names.reserve(vocabulary_.features.size());
      for (const Feature& known : vocabulary_.features) {
        names.push_back(known.name);
      }
      return wrong(name, fmt::format("a feature ({})", fmt::join(names, ", ")));
    }
    tokens_.advance();
    const Token op = tokens_.now();
    if (op.kind != Token::Kind::comparison) {
      return wrong(op, "=, !=, <=, <, >= or >");
    }
    const Feature& tested = vocabulary_.features[*feature];
    if (tested.scale == Scale::bins && op.text != "<=" && op.text != ">") {
      return wrong(op, fmt::format("<= or >: {} has bins", name.text));
    }
    tokens_.advance();
    const Token number = tokens_.now();
    const std::optional<std::uint8_t> bound =
        number.kind == Token::Kind::number ? tested.value_of_text(number.text) : std::nullopt;
    if (!bound) {
      return wrong(number, fmt::format("a value of {} ({})", name.text, tested.values_text()));
    }
    for (const std::uint8_t value : tested.values) {
      if (!compares(value, op.text, *bound)) {
        allowed[*feature].reset(value);
      }
    }
    tokens_.advance();
    return {};
  }

  Tokens tokens_;
  const Vocabulary& vocabulary_;
  Rule rule_;
};

}  // namespace

bool Rule::broken_by(ActionId action) const {
  const bool named = std::find(actions.begin(), actions.end(), action) != actions.end();
  return named != always;
}

bool Rule::applies(std::span<const std::uint8_t> features) const {
  return std::any_of(when.begin(), when.end(), [&](const std::vector<ValueSet>& allowed) {
    for (std::size_t f = 0; f < allowed.size(); ++f) {
      if (!allowed[f].test(features[f])) {
        return false;
      }
    }
    return true;
  });
}

Result<Rule> parse_rule(std::string_view text, const Vocabulary& vocabulary) {
  if (text.size() > kMaxRuleText) {
    return bad_input(fmt::format("a rule of {} characters: expected at most {}", text.size(), kMaxRuleText));
  }
  return Parser(text, vocabulary).parse();
}

Result<std::vector<Rule>> read_rules(const std::string& path, const Vocabulary& vocabulary) {
  std::ifstream in(path);
  if (!in) {
    return failed(fmt::format("cannot read {}: {}", path, std::generic_category().message(errno)));
  }
  std::vector<Rule> rules;
  std::string line;
  for (std::size_t number = 1; std::getline(in, line); ++number) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos || line[begin] == '#') {
      continue;
    }
    line.erase(line.find_last_not_of(" \t\r") + 1);
    Result<Rule> rule = parse_rule(line, vocabulary);
    if (!rule) {
      return in_context(fmt::format("{}: line {}", path, number), std::move(rule).error());
    }
    rules.push_back(std::move(*rule));
  }
  if (in.bad()) {
    return failed(fmt::format("cannot read {}: {}", path, std::generic_category().message(errno)));
  }
  if (rules.empty()) {
    return bad_input(fmt::format("{}: holds no rule: expected one a line", path));
  }
  return rules;
}

}  // namespace coppice
