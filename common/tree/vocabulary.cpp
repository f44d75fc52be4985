#include "common/tree/vocabulary.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "common/check.hpp"

namespace coppice {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= kMaxNameLength && is_letter(text.front()) &&
         std::all_of(text.begin(), text.end(), [](char c) { return is_letter(c) || is_digit(c); });
}

Result<void> check_name(const char* what, const std::string& name, std::set<std::string>& seen) {
  if (!is_name(name)) {
    return bad_input(
        fmt::format("{} name is malformed: expected a letter, then letters, digits or _, at most {} characters", what,
                    kMaxNameLength));
  }
  if (name == "sequence" || name == "selector") {
    return bad_input(fmt::format("{} name '{}' is reserved for a tree's composites", what, name));
  }
  if (!seen.insert(name).second) {
    return bad_input(fmt::format("{} name '{}' is used twice", what, name));
  }
  return {};
}

constexpr std::size_t kMaxListed = 24;  // values repeated in a message

Result<void> check_scale(const Feature& feature) {
  const std::size_t bins = feature.scale == Scale::bins ? 1 : 0;
  const std::size_t expected = feature.scale == Scale::plain ? 0 : feature.values.size() - bins;
  if (feature.numbers.size() != expected) {
    return bad_input(fmt::format("feature '{}' has {} numbers for {} values: expected {}", feature.name,
                                 feature.numbers.size(), feature.values.size(), expected));
  }
  for (std::size_t i = 0; i < feature.numbers.size(); ++i) {
    if (!std::isfinite(feature.numbers[i]) || (i > 0 && !(feature.numbers[i - 1] < feature.numbers[i]))) {
      return bad_input(fmt::format("feature '{}': number {} is {}: expected finite numbers in ascending order",
                                   feature.name, i, feature.numbers[i]));
    }
  }
  if (feature.scale == Scale::bins && feature.admits_equal) {
    return bad_input(fmt::format("feature '{}' has bins and admits '=': expected '<=' only", feature.name));
  }
  return {};
}

// Where a value stands among the feature's values.
std::size_t place_of(const Feature& feature, std::uint8_t value) {
  const auto found = std::lower_bound(feature.values.begin(), feature.values.end(), value);
  COPPICE_CHECK(found != feature.values.end() && *found == value);
  return static_cast<std::size_t>(found - feature.values.begin());
}

std::optional<double> number_in(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

}  // namespace

std::optional<std::uint8_t> Feature::value_of(double reading) const {
  switch (scale) {
    case Scale::plain: {
      const bool is_code = reading >= 0.0 && reading <= 255.0 && reading == std::floor(reading);
      const auto code = static_cast<std::uint8_t>(is_code ? reading : 0.0);
      return is_code && std::binary_search(values.begin(), values.end(), code) ? std::optional(code) : std::nullopt;
    }
    case Scale::numbers: {
      const auto found = std::lower_bound(numbers.begin(), numbers.end(), reading);
      return found != numbers.end() && *found == reading
                 ? std::optional(values[static_cast<std::size_t>(found - numbers.begin())])
                 : std::nullopt;
    }
    case Scale::bins:
      break;
  }
  if (std::isnan(reading)) {
    return std::nullopt;
  }
  return values[static_cast<std::size_t>(std::lower_bound(numbers.begin(), numbers.end(), reading) - numbers.begin())];
}

std::string Feature::number_text(std::uint8_t value) const {
  if (scale == Scale::plain) {
    return fmt::format("{}", value);
  }
  const std::size_t place = place_of(*this, value);
  return place == numbers.size() ? "inf" : fmt::format("{}", numbers[place]);
}

std::string Feature::reading_text(std::uint8_t value) const {
  if (scale != Scale::bins) {
    return fmt::format("{}={}", name, number_text(value));
  }
  const std::size_t place = place_of(*this, value);
  if (place == 0) {
    return fmt::format("{} in (-inf, {}]", name, number_text(value));
  }
  return fmt::format("{} in ({}, {}{}", name, numbers[place - 1], number_text(value),
                     place == numbers.size() ? ")" : "]");
}

std::optional<std::uint8_t> Feature::value_of_text(std::string_view text) const {
  if (scale == Scale::plain) {
    std::uint8_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_number =
        error == std::errc{} && end == text.data() + text.size() && (text.size() == 1 || text.front() != '0');
    return is_number && std::binary_search(values.begin(), values.end(), value) ? std::optional(value) : std::nullopt;
  }
  if (scale == Scale::bins && text == "inf") {
    return values.back();
  }
  const std::optional<double> number = number_in(text);
  if (!number) {
    return std::nullopt;
  }
  const auto found = std::lower_bound(numbers.begin(), numbers.end(), *number);
  return found != numbers.end() && *found == *number
             ? std::optional(values[static_cast<std::size_t>(found - numbers.begin())])
             : std::nullopt;
}

std::string Feature::values_text() const {
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i == kMaxListed && values.size() > kMaxListed + 1) {
      return text + fmt::format(", ... up to {}", number_text(values.back()));
    }
    text += (i == 0 ? "" : ", ") + number_text(values[i]);
  }
  return text;
}

std::optional<std::size_t> Vocabulary::find_feature(std::string_view name) const {
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (features[i].name == name) {
      return i;
    }
  }
  return std::nullopt;
}

std::optional<ActionId> Vocabulary::find_action(std::string_view name) const {
  for (std::size_t i = 0; i < actions.size(); ++i) {
    if (actions[i] == name) {
      return ActionId{static_cast<std::uint8_t>(i)};
    }
  }
  return std::nullopt;
}

Result<void> check_vocabulary(const Vocabulary& vocabulary) {
  if (vocabulary.features.empty() || vocabulary.features.size() > kMaxFeatures) {
    return bad_input(fmt::format("{} features: expected 1 to {}", vocabulary.features.size(), kMaxFeatures));
  }
  if (vocabulary.actions.empty() || vocabulary.actions.size() > kMaxActions) {
    return bad_input(fmt::format("{} actions: expected 1 to {}", vocabulary.actions.size(), kMaxActions));
  }
  std::set<std::string> seen;
  for (const Feature& feature : vocabulary.features) {
    if (auto ok = check_name("feature", feature.name, seen); !ok) {
      return ok;
    }
    const bool ascending = std::adjacent_find(feature.values.begin(), feature.values.end(), std::greater_equal<>()) ==
                           feature.values.end();
    if (feature.values.empty() || !ascending) {
      return bad_input(fmt::format("feature '{}': expected at least one value, in ascending order", feature.name));
    }
    if (feature.values.size() > kMaxValues) {
      return bad_input(fmt::format("feature '{}' has {} values: expected at most {}", feature.name,
                                   feature.values.size(), kMaxValues));
    }
    if (auto ok = check_scale(feature); !ok) {
      return ok;
    }
    if (!feature.admits_equal && !feature.admits_less_equal) {
      return bad_input(fmt::format("feature '{}' admits no operator: expected = or <= or both", feature.name));
    }
  }
  for (const std::string& action : vocabulary.actions) {
    if (auto ok = check_name("action", action, seen); !ok) {
      return ok;
    }
  }
  return {};
}

}  // namespace coppice
