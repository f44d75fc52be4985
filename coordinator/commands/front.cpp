#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "common/tree/text.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/output_option.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/simulate_option.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/progress.hpp"
#include "coordinator/console/whole_file.hpp"
#include "coordinator/report/front_plot.hpp"
#include "coordinator/report/front_report.hpp"
#include "coordinator/runs/simulate_study.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

struct FrontFlags {
  std::string study;
  std::optional<std::int64_t> run;
  std::string rule;
  OutputOption output;  // --force is for the plot too
  SimulateOption simulate{.episodes = 0};
  std::string plot;
  std::string axes;
  bool json = false;
};

struct FoundFront {
  RunRecord run;
  Front front;
};

// The front of the run asked for, or of the last run that has one.
Result<FoundFront> front_of(const Study& study, std::optional<std::int64_t> wanted) {
  if (wanted) {
    auto run = study.run(RunId{*wanted});
    if (!run) {
      return tl::unexpected(run.error());
    }
    auto front = study.front(run->id);
    if (!front) {
      return tl::unexpected(front.error());
    }
    if (front->members.empty()) {
      return bad_input(
          fmt::format("{}: run {} has no front: expected a finished run with ga.search=front", study.path(), *wanted));
    }
    return FoundFront{std::move(*run), std::move(*front)};
  }
  auto runs = study.runs();
  if (!runs) {
    return tl::unexpected(runs.error());
  }
  for (auto run = runs->rbegin(); run != runs->rend(); ++run) {
    auto front = study.front(run->id);
    if (!front) {
      return tl::unexpected(front.error());
    }
    if (!front->members.empty()) {
      return FoundFront{std::move(*run), std::move(*front)};
    }
  }
  return bad_input(
      fmt::format("{}: no run has a front: expected one of 'coppice evolve --set ga.search=front'", study.path()));
}

// Every tree of the front in the simulator, all on the same episodes. [members]
Result<std::vector<ControllerScore>> simulate_front(const Study& study, const Front& front,
                                                    const SimulateOption& option, const StopFlag& stop) {
  const SimulateSettings settings = settings_of(option, study);
  std::vector<Tree> trees;
  trees.reserve(front.members.size());
  for (const FrontMember& member : front.members) {
    trees.push_back(member.tree);
  }
  Progress progress(stderr, progress_settings_for(stderr), "front", "trees", trees.size());
  const auto all =
      simulated_all(study, trees, settings, option.simulator, stop, [&](std::size_t done) { progress.update(done); });
  if (!all) {
    return tl::unexpected(all.error());
  }
  if (!*all) {
    return bad_input(fmt::format(
        "{}: has no simulator: expected --simulator COMMAND with --episodes, or a study of one of our worlds",
        study.path()));
  }
  std::vector<ControllerScore> scores;
  for (const std::vector<EpisodeRecord>& episodes : **all) {
    scores.push_back(controller_score(episodes));
  }
  return scores;
}

Result<void> front_command(const FrontFlags& options, const StopFlag& stop) {
  if (options.simulate.episodes == 0 && !options.simulate.simulator.empty()) {
    return bad_input("--simulator without --episodes: expected how many episodes each tree is to walk");
  }
  std::optional<PickRule> rule;
  if (!options.rule.empty()) {
    auto parsed = parse_pick(options.rule);
    if (!parsed) {
      return in_context("--pick", parsed.error());
    }
    rule = std::move(*parsed);
  }
  for (const auto& [flag, path] : {std::pair{"-o", &options.output.path}, std::pair{"--plot", &options.plot}}) {
    if (const Result<void> checked = check_output(flag, *path, options.output.force, options.study); !checked) {
      return checked;
    }
  }
  if (!options.plot.empty()) {
    if (const Result<PictureFormat> format = picture_format(options.plot); !format) {
      return in_context("--plot", format.error());
    }
  }
  const Result<Study> study = Study::open(options.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(study.error());
  }
  const Result<FoundFront> found = front_of(*study, options.run);
  if (!found) {
    return tl::unexpected(found.error());
  }
  const Front& front = found->front;
  const Vocabulary& vocabulary = study->chain().vocabulary();
  std::optional<std::size_t> picked;
  if (rule) {
    picked = pick(front, *rule);
    if (!picked) {
      return bad_input(fmt::format("--pick {}: fits none of the {} on the front of run {}", options.rule,
                                   counted(front.members.size(), "tree"), static_cast<std::int64_t>(found->run.id)));
    }
  } else if (found->run.tree) {
    for (std::size_t i = 0; i < front.members.size() && !picked; ++i) {
      picked = front.members[i].tree == *found->run.tree ? std::optional(i) : std::nullopt;
    }
  }
  std::optional<FrontAxes> axes;
  if (!options.plot.empty()) {
    const auto chosen = axes_from(options.axes, front);
    if (!chosen) {
      return in_context("--axes", chosen.error());
    }
    axes = *chosen;
  }
  if (axes) {
    if (const auto written = write_front_plot(front, *axes, picked, options.plot); !written) {
      return written;
    }
  }
  std::vector<ControllerScore> scores;
  if (options.simulate.episodes > 0) {
    auto simulated = simulate_front(*study, front, options.simulate, stop);
    if (!simulated) {
      return tl::unexpected(simulated.error());
    }
    scores = std::move(*simulated);
    if (const Result<void> kept = keep_simulator(options.study, options.simulate.simulator); !kept) {
      return kept;
    }
  }
  if (!options.output.path.empty() && picked) {
    const std::string text = to_text(front.members[*picked].tree, vocabulary) + "\n";
    if (const auto written = write_whole_file(options.output.path, text); !written) {
      return written;
    }
  }
  if (options.json) {
    fmt::print("{}\n", to_json(front, vocabulary, picked, scores));
  } else if (rule) {
    fmt::print("{}\n", to_text(front.members[*picked].tree, vocabulary));
  } else {
    fmt::print("run {}: {}; < is the answer; return, collisions and unknown a walk of {}\n{}",
               static_cast<std::int64_t>(found->run.id), counted(front.members.size(), "tree"),
               counted(found->run.config.rollout.steps, "step"), to_text(front, picked, scores));
  }
  return {};
}

}  // namespace

void add_front(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<FrontFlags>();
  CLI::App* command = app.add_subcommand("front", "List the trees that none other beats in every measure, pick one");
  add_study_argument(*command, options->study);
  add_run_option(*command, options->run, "The front of this run (default: the last that has one)");
  CLI::Option* pick_option =
      command->add_option("--pick", options->rule, "Print the one tree that this rule chooses")->type_name("RULE");
  add_output_option(*command, options->output, "Also write the picked tree to a file, for --tree FILE")
      ->needs(pick_option);
  CLI::Option* plot = command->add_option("--plot", options->plot, "Draw two measures")->type_name("FILE.svg|.png");
  options->axes = "coverage,agreement";
  command->add_option("--axes", options->axes, "Which two, across and up")
      ->type_name("X,Y")
      ->needs(plot)
      ->capture_default_str();
  add_simulate_option(*command, options->simulate,
                      {.episodes = "Also walk each tree in the simulator, in so many episodes (0: none)"});
  add_json_flag(*command, options->json, "The front as one JSON list");
  command->footer(
      "A rule: best MEASURE [with MEASURE<=NUMBER and ...] [else best ...], with <=, >= or =; shares are from 0 to 1;\n"
      "a measure is one that the run evaluated, nodes, or fitness.\n"
      "Examples:\n"
      "  coppice front uav.coppice --plot front.svg\n"
      "  coppice front uav.coppice --pick 'best return with nodes<=20 and coverage>=0.8' -o best.tree\n"
      "  coppice front cart.coppice --episodes 50\n"
      "  coppice score uav.coppice --tree best.tree");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return front_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
