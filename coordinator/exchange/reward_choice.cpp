#include "coordinator/exchange/reward_choice.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "coordinator/exchange/text_number.hpp"

namespace coppice {

Result<RewardWeights> choose_reward(const std::vector<std::string>& names, const std::string& wanted) {
  RewardWeights weights{std::vector<double>(names.size(), 0.0)};
  const auto place = [&](std::string_view name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  if (wanted.empty()) {
    if (names.size() == 1) {
      weights.weight[0] = 1.0;
    } else if (names.size() == 2 && place("gain") < 2 && place("cost") < 2) {
      weights.weight[place("gain")] = 1.0;
      weights.weight[place("cost")] = -1.0;
    } else if (!names.empty()) {
      return bad_input(fmt::format("the model has several rewards ({}): choose with --reward, as in --reward '{} - {}'",
                                   fmt::join(names, ", "), names[0], names[1]));
    }
    return weights;
  }
  if (place(wanted) < names.size()) {
    weights.weight[place(wanted)] = 1.0;
    return weights;
  }
  double sign = 1.0;
  bool name_expected = true;
  std::string_view rest = wanted;
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
    if (word == "-" || word == "+") {
      sign = word == "-" ? -1.0 : 1.0;
      name_expected = true;
      continue;
    }
    if (!name_expected || place(word) == names.size()) {
      return bad_input(
          fmt::format("no reward '{}' in the model: expected one of ({}), or several with signs between "
                      "blanks",
                      word, fmt::join(names, ", ")));
    }
    weights.weight[place(word)] += sign;
    name_expected = false;
  }
  return weights;
}

}  // namespace coppice
