#include "coordinator/report/draw.hpp"

#include <CLI/CLI.hpp>
#include <memory>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/output_option.hpp"
#include "coordinator/commands/study_tree.hpp"

namespace coppice {
namespace {

struct DrawFlags {
  StudyTreeOption tree;
  OutputOption output;
};

Result<void> draw_command(const DrawFlags& options) {
  if (const Result<DrawingFormat> format = drawing_format(options.output.path); !format) {
    return in_context("-o", format.error());
  }
  const auto& [path, force] = options.output;
  if (const Result<void> checked = check_output("-o", path, force, options.tree.study); !checked) {
    return checked;
  }
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  return write_drawing(tree, study.chain().vocabulary(), study.problem(), options.output.path);
}

}  // namespace

void add_draw(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<DrawFlags>();
  CLI::App* command = app.add_subcommand("draw", "Draw a tree with Graphviz");
  add_study_tree(*command, options->tree);
  add_output_option(*command, options->output, "The drawing; the extension chooses its format", "FILE.svg|.png|.dot")
      ->required();
  command->footer(
      "Examples:\n"
      "  coppice draw uav.coppice -o tree.svg\n"
      "  coppice draw uav.coppice --tree '(sequence s3=0 turn_left)' -o tree.dot");
  command->callback([&invocation, options] { invocation.chosen = [options] { return draw_command(*options); }; });
}

}  // namespace coppice
