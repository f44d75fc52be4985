// Trees in text form, one a line, as files and pipes hold them: blank around the tree is allowed, lines that start
// with # are comments. Reads one line at a time, so that any number of trees needs the memory of one.
#pragma once

#include <cstdint>
#include <optional>
#include <streambuf>
#include <string>

#include "common/error.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

class TreeLines {
 public:
  enum class Event : std::uint8_t { tree, empty_line, end };

  // `name` stands for the input in messages. REQUIRES: `in` and `vocabulary` outlive this.
  TreeLines(std::streambuf& in, std::string name, const Vocabulary& vocabulary);

  // Reads on to the next tree, empty line or the end. Errors name input, line and column: a tree that is malformed, a
  // line of more than kMaxTreeText characters.
  Result<Event> next();

  // The tree just read. REQUIRES: the last next() was Event::tree.
  const Tree& tree() const { return *tree_; }

 private:
  // False at the end. Errors: the line is too long, or the input failed.
  Result<bool> read_line();

  std::streambuf& in_;
  std::string name_;
  const Vocabulary& vocabulary_;
  std::uint64_t line_number_ = 0;
  std::string line_;
  std::optional<Tree> tree_;
};

}  // namespace coppice
