#include "coordinator/report/draw.hpp"

#include <CLI/CLI.hpp>
#include <memory>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/tree_option.hpp"
#include "coordinator/report/whole_file.hpp"

namespace coppice {
namespace {

struct Options {
  std::string study;
  TreeOption tree;
  std::string output;
};

Result<void> draw_command(const Options& options) {
  if (const Result<DrawingFormat> format = drawing_format(options.output); !format) {
    return in_context("-o", format.error());
  }
  const Result<Study> study = Study::open(options.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(study.error());
  }
  if (const Result<void> other = check_other_file("-o", options.output, options.study); !other) {
    return other;
  }
  const Result<Tree> tree = tree_of(options.tree, *study);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  return write_drawing(*tree, study->chain().vocabulary(), options.output);
}

}  // namespace

void add_draw(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("draw", "Draw a tree with Graphviz");
  command->add_option("STUDY", options->study, "The study file")->required();
  add_tree_option(*command, options->tree);
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
