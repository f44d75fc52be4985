// parse_tree_document(): whatever it accepts, as XML of BehaviorTree.CPP or as JSON, is a tree of the vocabulary within
// the limits that is written and read back as the same tree in both forms.
#include "common/check.hpp"
#include "coordinator/exchange/behavior_tree_xml.hpp"
#include "coordinator/exchange/tree_file.hpp"
#include "coordinator/exchange/tree_json.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

void test(std::string_view text) {
  if (tree_form(text) == TreeForm::text) {
    accepted = false;
    return;
  }
  const auto tree = parse_tree_document(text, "input", words());
  accepted = tree.has_value();
  if (!tree) {
    COPPICE_CHECK(is_refusal(tree.error()));
    COPPICE_CHECK(tree.error().message.find('\n') == std::string::npos);
    return;
  }
  COPPICE_CHECK(tree->size() <= kMaxTreeNodes && tree->depth() <= kMaxTreeDepth);
  COPPICE_CHECK(check_tree(*tree, words()).has_value());
  const Problem problem = unlabelled(words());
  const ExportedTree exported{*tree, words(), problem, "input"};
  const auto from_json = parse_tree_document(to_tree_json(exported), "json", words());
  COPPICE_CHECK(from_json.has_value() && *from_json == *tree);
  const auto xml = to_behavior_tree_xml(exported, BehaviorTreeStyle::scripts);
  COPPICE_CHECK(xml.has_value());
  const auto from_xml = parse_tree_document(*xml, "xml", words());
  COPPICE_CHECK(from_xml.has_value() && *from_xml == *tree);
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test(coppice::fuzz::as_text(data, size));
  return 0;
}
