#include "common/tree/vocabulary.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

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

}  // namespace

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
