#include "coordinator/report/draw.hpp"

#include <fmt/format.h>
#include <iterator>
#include <string_view>
#include <vector>

#include "common/tree/text.hpp"
#include "coordinator/console/subprocess.hpp"
#include "coordinator/console/whole_file.hpp"

namespace coppice {
namespace {

// A DOT string: only the quote and the backslash are special inside double quotes.
std::string dot_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += '\\';
    }
    result += c;
  }
  return result + "\"";
}

// As a DOT string. Words stand under the text form, which stays: that is what logs and the command line show.
std::string label_of(const Node& node, const Vocabulary& vocabulary, const Problem& problem) {
  switch (node.kind) {
    case NodeKind::sequence:
      return dot_string("\xE2\x86\x92");  // U+2192, rightwards arrow
    case NodeKind::selector:
      return dot_string("?");
    case NodeKind::condition:
    case NodeKind::action:
      break;
  }
  std::string label = dot_string(to_text(node, vocabulary));
  if (const std::string words = in_words(node, problem, vocabulary); !words.empty()) {
    label.pop_back();
    label += "\\n" + dot_string(words).substr(1);
  }
  return label;
}

std::string_view shape_of(const Node& node) {
  switch (node.kind) {
    case NodeKind::condition:
      return "ellipse";
    case NodeKind::action:
      return "box";
    case NodeKind::sequence:
    case NodeKind::selector:
      break;
  }
  return "square";
}

tl::unexpected<Error> no_dot() {
  return failed("the program 'dot' of Graphviz is not on PATH: install graphviz, or write a .dot file");
}

}  // namespace

std::string to_dot(const Tree& tree, const Vocabulary& vocabulary, const Problem& problem) {
  std::string text =
      "digraph tree {\n"
      "  graph [ordering=out];\n"
      "  node [fontname=\"Helvetica\", fontsize=12];\n"
      "  edge [arrowsize=0.6];\n";
  struct Open {
    std::size_t node;
    std::size_t end;
  };
  std::vector<Open> open;  // composites around the current node, outermost first
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Node& node = tree[i];
    while (!open.empty() && open.back().end <= i) {
      open.pop_back();
    }
    fmt::format_to(std::back_inserter(text), "  n{} [shape={}, label={}];\n", i, shape_of(node),
                   label_of(node, vocabulary, problem));
    if (!open.empty()) {
      fmt::format_to(std::back_inserter(text), "  n{} -> n{};\n", open.back().node, i);
    }
    if (node.is_composite()) {
      open.push_back({i, i + node.extent});
    }
  }
  return text + "}\n";
}

Result<DrawingFormat> drawing_format(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".dot") {
    return DrawingFormat::dot;
  }
  if (extension == ".svg") {
    return DrawingFormat::svg;
  }
  if (extension == ".png") {
    return DrawingFormat::png;
  }
  return bad_input(
      fmt::format("{}: drawing has extension '{}': expected .svg, .png or .dot", path.string(), extension));
}

Result<void> check_dot() { return has_program("dot") ? Result<void>() : no_dot(); }

Result<void> write_drawing(const Tree& tree, const Vocabulary& vocabulary, const Problem& problem,
                           const std::filesystem::path& path) {
  const Result<DrawingFormat> format = drawing_format(path);
  if (!format) {
    return tl::unexpected(format.error());
  }
  const std::string source = to_dot(tree, vocabulary, problem);
  if (*format == DrawingFormat::dot) {
    return write_whole_file(path, source);
  }
  const std::string_view program_format = *format == DrawingFormat::svg ? "svg" : "png";
  return produce_whole_file(path, [&](const std::filesystem::path& temporary) -> Result<void> {
    if (auto found = check_dot(); !found) {
      return found;
    }
    return run_program(
        {"dot", fmt::format("-T{}", program_format), "-o", std::filesystem::absolute(temporary).string()}, source);
  });
}

}  // namespace coppice
