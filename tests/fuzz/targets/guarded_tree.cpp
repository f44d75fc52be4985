// guard(): whatever tree it is given, the result is a guarded tree of the vocabulary that ticks alike, and
// guarding it again makes it no larger. Reads the corpus of tree_text; the parser's trees have shapes that no random
// tree has.
#include <array>

#include "common/chain/random.hpp"
#include "common/check.hpp"
#include "common/tree/guard.hpp"
#include "common/tree/text.hpp"
#include "common/tree/tick.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

constexpr std::size_t kMaxNodes = 200;
constexpr std::size_t kObservations = 64;
constexpr std::size_t kFeatures = 10;

// Drawn once, the same for all trees.
std::array<std::array<std::uint8_t, kFeatures>, kObservations> draw_observations() {
  COPPICE_CHECK(words().features.size() == kFeatures);
  Xoshiro256 random(1);
  std::array<std::array<std::uint8_t, kFeatures>, kObservations> observations{};
  for (auto& observation : observations) {
    for (std::size_t f = 0; f < kFeatures; ++f) {
      const auto& values = words().features[f].values;
      observation[f] = values[random.below(values.size())];
    }
  }
  return observations;
}

void test(std::string_view text) {
  static const auto observations = draw_observations();
  const auto tree = parse_tree(text, words());
  accepted = tree.has_value();
  if (!tree || tree->size() > kMaxNodes) {
    return;
  }
  const auto guarded = guard(*tree, words());
  if (!guarded) {
    COPPICE_CHECK(is_printable_refusal(guarded.error()));
    return;
  }
  COPPICE_CHECK(check_tree(*guarded, words()).has_value() && is_guarded(*guarded));
  for (const auto& observation : observations) {
    COPPICE_CHECK(tick(*guarded, observation) == tick(*tree, observation));
  }
  const auto again = guard(*guarded, words());
  COPPICE_CHECK(again.has_value() && again->size() <= guarded->size());
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::one_line(coppice::fuzz::as_text(data, size)));
  return 0;
}
