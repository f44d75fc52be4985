#include "coordinator/report/score.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/learn_options.hpp"
#include "coordinator/commands/tree_option.hpp"
#include "coordinator/commands/whole_number.hpp"

namespace coppice {
namespace {

struct Options {
  std::string study;
  TreeOption tree;
  std::uint64_t episodes = SimulateSettings{}.episodes;
  std::optional<std::uint32_t> steps;
  std::uint64_t seed = SimulateSettings{}.seed;
  std::uint64_t seen = kSeenVisits;
  bool exact = false;
  bool json = false;
};

Result<void> score_command(const Options& options, const StopFlag& stop) {
  const Result<Study> study = Study::open(options.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(study.error());
  }
  const Result<Tree> tree = tree_of(options.tree, *study);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  const Result<World> world = make_world(study->world().kind, study->world().room);
  if (!world) {
    return in_context(options.study, world.error());
  }
  const SimulateSettings settings{.episodes = options.episodes,
                                  .steps = options.steps ? *options.steps : learned_steps(*study),
                                  .seed = options.seed};
  Result<Score> score = score_tree(
      *world, study->chain(), *tree, settings, [&] { return !stop.raised(); }, options.seen);
  if (!score) {
    return tl::unexpected(score.error());
  }
  if (options.exact) {
    add_exact(study->chain(), *tree, *score);
  }
  if (options.json) {
    fmt::print("{}\n", to_json(*score));
  } else {
    fmt::print("{}", to_text(*score));
  }
  return {};
}

}  // namespace

void add_score(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("score", "Compare a tree with the learned policy: Table IV of the thesis");
  command->add_option("STUDY", options->study, "The study file")->required();
  add_tree_option(*command, options->tree);
  command->add_option("--episodes", options->episodes, "Episodes in the simulator; 500 or more for narrow intervals")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--steps", options->steps, "Steps per episode (default: as in learning)")->check(whole_number());
  command->add_option("--seed", options->seed, "Of the simulator")->check(whole_number())->capture_default_str();
  command->add_option("--seen", options->seen, "Also agreement over the states visited so often or more in learning")
      ->type_name("N")
      ->check(whole_number())
      ->capture_default_str();
  command->add_flag("--exact", options->exact,
                    "Also what is expected along the chain, computed: agreement and reward over --steps steps");
  command->add_flag("--json", options->json, "Report as one JSON object");
  command->footer(
      "Examples:\n"
      "  coppice score uav.coppice\n"
      "  coppice score uav.coppice --exact\n"
      "  coppice score uav.coppice --tree '(selector (sequence s3=0 turn_left) move)' --episodes 5000");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return score_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
