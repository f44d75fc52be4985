#include "coordinator/runs/tree_lines.hpp"

#include <fmt/format.h>
#include <string_view>
#include <utility>

#include "common/check.hpp"
#include "common/tree/text.hpp"

namespace coppice {
namespace {

constexpr std::string_view kBlank = " \t\r";

}  // namespace

TreeLines::TreeLines(std::streambuf& in, std::string name, const Vocabulary& vocabulary)
    : in_(in), name_(std::move(name)), vocabulary_(vocabulary) {}

Result<bool> TreeLines::read_line() {
  line_.clear();
  constexpr auto kEnd = std::char_traits<char>::eof();
  for (auto c = in_.sbumpc(); c != std::char_traits<char>::to_int_type('\n'); c = in_.sbumpc()) {
    if (c == kEnd) {
      return !line_.empty();
    }
    if (line_.size() == kMaxTreeText) {
      return bad_input(fmt::format("{}: line {}: more than {} characters: expected one tree a line", name_,
                                   line_number_ + 1, kMaxTreeText));
    }
    line_ += std::char_traits<char>::to_char_type(c);
  }
  return true;
}

Result<TreeLines::Event> TreeLines::next() {
  // Ends with the input: every turn consumes a line.
  while (true) {
    const Result<bool> read = read_line();
    if (!read) {
      return tl::unexpected(read.error());
    }
    if (!*read) {
      return Event::end;
    }
    ++line_number_;
    const std::size_t end = line_.find_last_not_of(kBlank);
    if (end == std::string::npos) {
      return Event::empty_line;
    }
    if (line_[line_.find_first_not_of(kBlank)] == '#') {
      continue;
    }
    line_.resize(end + 1);  // what is before the tree stays, so that columns in messages are those of the file
    Result<Tree> parsed = parse_tree(line_, vocabulary_);
    if (!parsed) {
      return in_context(fmt::format("{}: line {}", name_, line_number_), std::move(parsed).error());
    }
    tree_ = std::move(*parsed);
    return Event::tree;
  }
}

}  // namespace coppice
