// parse_rule(): refused, or a rule of the vocabulary whose proof agrees with ticks.
#include <array>

#include "common/chain/random.hpp"
#include "common/check.hpp"
#include "common/tree/text.hpp"
#include "common/tree/tick.hpp"
#include "coordinator/trust/rule_check.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

constexpr std::size_t kObservations = 32;

std::vector<std::vector<std::uint8_t>> draw_observations() {
  Xoshiro256 random(1);
  std::vector<std::vector<std::uint8_t>> observations(kObservations);
  for (auto& observation : observations) {
    for (const Feature& feature : words().features) {
      observation.push_back(feature.values[random.below(feature.values.size())]);
    }
  }
  return observations;
}

void test(std::string_view text) {
  static const auto observations = draw_observations();
  static const Tree tree = *parse_tree(
      "(selector (sequence s3=0 turn_left s1=1) (sequence s5=3 turn_right) (sequence s1=3 s0=0 move))", words());
  const auto rule = parse_rule(text, words());
  accepted = rule.has_value();
  if (!rule) {
    COPPICE_CHECK(is_refusal(rule.error()));
    return;
  }
  COPPICE_CHECK(!rule->actions.empty() && !rule->when.empty());
  for (const auto& allowed : rule->when) {
    COPPICE_CHECK(allowed.size() == words().features.size());
    for (const ValueSet& values : allowed) {
      COPPICE_CHECK(values.any());
    }
  }
  const auto answer = check_rule(*rule, tree, words());
  COPPICE_CHECK(answer.has_value());
  if (answer->broken) {
    const Counterexample& example = *answer->broken;
    COPPICE_CHECK(rule->applies(example.features) && tick(tree, example.features) == example.action);
    COPPICE_CHECK(rule->broken_by(example.action));
    return;
  }
  for (const auto& observation : observations) {
    COPPICE_CHECK(!rule->applies(observation) || !rule->broken_by(tick(tree, observation)));
  }
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::one_line(coppice::fuzz::as_text(data, size)));
  return 0;
}
