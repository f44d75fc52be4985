// simplify(): whatever tree it is given, the result is a tree of the vocabulary, not larger, that ticks alike and has
// nothing left to remove. Reads the corpus of tree_text; the parser's trees have shapes that no random tree has.
#include "common/check.hpp"
#include "common/tree/simplify.hpp"
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
  const Simplified simplified = simplify(*tree, words());
  COPPICE_CHECK(check_tree(simplified.tree, words()).has_value());
  std::size_t removed = 0;
  for (const Removal& removal : simplified.removals) {
    COPPICE_CHECK(!removal.what.empty() && !removal.reason.empty());
    removed += removal.nodes;
  }
  COPPICE_CHECK(simplified.tree.size() + removed == tree->size());
  check_ticks_alike(simplified.tree, *tree);
  COPPICE_CHECK(simplify(simplified.tree, words()).removals.empty());
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::one_line(coppice::fuzz::as_text(data, size)));
  return 0;
}
