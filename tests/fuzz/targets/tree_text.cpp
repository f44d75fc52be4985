// parse_tree(): whatever it accepts is a tree of the vocabulary within the limits, and its text is that tree's.
#include "common/check.hpp"
#include "common/tree/text.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

void test(std::string_view text) {
  const auto tree = parse_tree(text, words());
  accepted = tree.has_value();
  if (!tree) {
    COPPICE_CHECK(is_printable_refusal(tree.error()));
    return;
  }
  COPPICE_CHECK(tree->size() <= kMaxTreeNodes && tree->depth() <= kMaxTreeDepth);
  COPPICE_CHECK(check_tree(*tree, words()).has_value());
  COPPICE_CHECK(Tree::from_nodes({tree->nodes().begin(), tree->nodes().end()}) == *tree);
  const std::string canonical = to_text(*tree, words());
  const auto again = parse_tree(canonical, words());
  COPPICE_CHECK(again.has_value() && *again == *tree);
  COPPICE_CHECK(to_text(*again, words()) == canonical);
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::one_line(coppice::fuzz::as_text(data, size)));
  return 0;
}
