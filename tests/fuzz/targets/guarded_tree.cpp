// guard(): whatever tree it is given, the result is a guarded tree of the vocabulary that ticks alike, and
// guarding it again makes it no larger. Reads the corpus of tree_text; the parser's trees have shapes that no random
// tree has.
#include "common/check.hpp"
#include "common/tree/guard.hpp"
#include "common/tree/text.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

constexpr std::size_t kMaxNodes = 200;

void test(std::string_view text) {
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
  check_ticks_alike(*guarded, *tree);
  const auto again = guard(*guarded, words());
  COPPICE_CHECK(again.has_value() && again->size() <= guarded->size());
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::one_line(coppice::fuzz::as_text(data, size)));
  return 0;
}
