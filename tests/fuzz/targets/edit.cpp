// parse_edit() and apply_edits(): refused, or a tree of the vocabulary. The first character says which change the rest
// is.
#include "coordinator/trust/edit.hpp"

#include "common/check.hpp"
#include "common/tree/text.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

void test(std::string_view text) {
  static const Tree tree = *parse_tree("(selector (sequence s3=0 turn_left) (selector s1=1 s5=3) move)", words());
  accepted = false;
  if (text.empty()) {
    return;
  }
  const auto kind = text.front() == 'r'   ? TreeEdit::Kind::replace
                    : text.front() == 'i' ? TreeEdit::Kind::insert
                                          : TreeEdit::Kind::remove;
  const auto edit = parse_edit(kind, text.substr(1), words());
  if (!edit) {
    COPPICE_CHECK(is_refusal(edit.error()));
    return;
  }
  COPPICE_CHECK(edit->subtree.has_value() == (kind != TreeEdit::Kind::remove));
  const auto edited = apply_edits(tree, {*edit});
  accepted = edited.has_value();
  if (!edited) {
    COPPICE_CHECK(is_refusal(edited.error()));
    return;
  }
  COPPICE_CHECK(check_tree(*edited, words()).has_value());
  const std::size_t added = edit->subtree ? edit->subtree->size() : 0;
  const std::size_t gone = kind == TreeEdit::Kind::insert ? 0 : tree[edit->node].extent;
  COPPICE_CHECK(edited->size() == tree.size() + added - gone);
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::one_line(coppice::fuzz::as_text(data, size)));
  return 0;
}
