#include "coordinator/report/draw.hpp"

#include <CLI/CLI.hpp>
#include <memory>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/report/whole_file.hpp"

namespace coppice {
namespace {

struct Options {
  StudyTreeOption tree;
  std::string output;
};

Result<void> draw_command(const Options& options) {
  if (const Result<DrawingFormat> format = drawing_format(options.output); !format) {
    return in_context("-o", format.error());
  }
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  if (const Result<void> other = check_other_file("-o", options.output, options.tree.study); !other) {
    return other;
  }
  return write_drawing(tree, study.chain().vocabulary(), options.output);
}

}  // namespace

void add_draw(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("draw", "Draw a tree with Graphviz");
  add_study_tree(*command, options->tree);
  command->add_option("-o,--output", options->output, "The drawing; the extension chooses its format")
      ->type_name("FILE.svg|.png|.dot")
      ->required();
  command->footer(
      "Examples:\n"
      "  coppice draw uav.coppice -o tree.svg\n"
      "  coppice draw uav.coppice --tree '(sequence s3=0 turn_left)' -o tree.dot");
  command->callback([&invocation, options] { invocation.chosen = [options] { return draw_command(*options); }; });
}

}  // namespace coppice
