// What the tests of common/tree draw from: vocabularies, observations and trees, by chance but the same every time.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/random.hpp"
#include "common/tree/random_tree.hpp"
#include "common/tree/text.hpp"
#include "common/tree/tree.hpp"
#include "common/tree/vocabulary.hpp"

namespace coppice::arbitrary {

inline Below below_of(Xoshiro256& random) {
  return [&random](std::uint64_t n) { return random.below(n); };
}

// The UAV of the thesis: eight sensors, 0 wall, 1 free, 3 trash.
inline Vocabulary uav() {
  Vocabulary vocabulary;
  for (int sensor = 0; sensor < 8; ++sensor) {
    vocabulary.features.push_back({fmt::format("s{}", sensor), {0, 1, 3}});
  }
  vocabulary.actions = {"move", "turn_left", "turn_right"};
  return vocabulary;
}

// `features` features of 1 to `values` values each, with = or <= or both.
inline Vocabulary vocabulary(Xoshiro256& random, std::size_t features, std::size_t values, std::size_t actions) {
  Vocabulary result;
  for (std::size_t f = 0; f < features; ++f) {
    Feature feature{fmt::format("f{}", f), {}};
    std::uint8_t value = static_cast<std::uint8_t>(random.below(3));
    for (std::size_t count = 1 + random.below(values); count > 0; --count) {
      feature.values.push_back(value);
      value = static_cast<std::uint8_t>(value + 1 + random.below(2));
    }
    const std::uint64_t ops = random.below(3);
    feature.admits_equal = ops != 0;
    feature.admits_less_equal = ops != 1;
    result.features.push_back(feature);
  }
  for (std::size_t a = 0; a < actions; ++a) {
    result.actions.push_back(fmt::format("a{}", a));
  }
  return result;
}

// [count x features]
inline std::vector<std::uint8_t> observations(Xoshiro256& random, const Vocabulary& vocabulary, std::size_t count) {
  std::vector<std::uint8_t> rows;
  for (std::size_t i = 0; i < count; ++i) {
    for (const Feature& feature : vocabulary.features) {
      rows.push_back(feature.values[random.below(feature.values.size())]);
    }
  }
  return rows;
}

// Every observation that the vocabulary allows. [product of value counts x features]
inline std::vector<std::uint8_t> all_observations(const Vocabulary& vocabulary) {
  std::vector<std::uint8_t> rows;
  std::vector<std::size_t> at(vocabulary.features.size(), 0);
  for (bool more = true; more;) {
    for (std::size_t f = 0; f < at.size(); ++f) {
      rows.push_back(vocabulary.features[f].values[at[f]]);
    }
    more = false;
    for (std::size_t f = 0; f < at.size() && !more; ++f) {
      more = ++at[f] < vocabulary.features[f].values.size();
      at[f] = more ? at[f] : 0;
    }
  }
  return rows;
}

inline std::span<const std::uint8_t> row(const std::vector<std::uint8_t>& rows, const Vocabulary& vocabulary,
                                         std::size_t i) {
  return std::span<const std::uint8_t>(rows).subspan(i * vocabulary.features.size(), vocabulary.features.size());
}

// REQUIRES: text is a tree.
inline Tree tree(std::string_view text, const Vocabulary& vocabulary) {
  Result<Tree> parsed = parse_tree(text, vocabulary);
  if (!parsed) {
    std::fprintf(stderr, "%s\n", parsed.error().message.c_str());
    std::abort();
  }
  return *parsed;
}

}  // namespace coppice::arbitrary
