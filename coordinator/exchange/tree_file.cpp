#include "coordinator/exchange/tree_file.hpp"

#include "common/check.hpp"
#include "coordinator/exchange/behavior_tree_reader.hpp"
#include "coordinator/exchange/tree_json.hpp"

namespace coppice {

TreeForm tree_form(std::string_view content) {
  const std::size_t first = content.find_first_not_of("\xEF\xBB\xBF \t\r\n");  // behind a byte order mark, if any
  if (first == std::string_view::npos) {
    return TreeForm::text;
  }
  return content[first] == '<' ? TreeForm::behavior_tree_xml : content[first] == '{' ? TreeForm::json : TreeForm::text;
}

Result<Tree> parse_tree_document(std::string_view content, const std::string& name, const Vocabulary& vocabulary) {
  const TreeForm form = tree_form(content);
  COPPICE_CHECK(form != TreeForm::text);
  return form == TreeForm::json ? parse_tree_json(content, name, vocabulary)
                                : parse_behavior_tree_xml(content, name, vocabulary);
}

}  // namespace coppice
