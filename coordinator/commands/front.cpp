#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "common/tree/text.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/output_option.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/whole_file.hpp"
#include "coordinator/report/front_plot.hpp"
#include "coordinator/report/front_report.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

struct Options {
  std::string study;
  std::optional<std::int64_t> run;
  std::string rule;
  OutputOption output;  // --force is for the plot too
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

Result<void> front_command(const Options& options) {
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
  if (!options.output.path.empty() && picked) {
    const std::string text = to_text(front.members[*picked].tree, vocabulary) + "\n";
    if (const auto written = write_whole_file(options.output.path, text); !written) {
      return written;
    }
  }
  if (options.json) {
    fmt::print("{}\n", to_json(front, vocabulary, picked));
  } else if (rule) {
    fmt::print("{}\n", to_text(front.members[*picked].tree, vocabulary));
  } else {
    fmt::print("run {}: {}; < is the answer; return, collisions and unknown a walk of {}\n{}",
               static_cast<std::int64_t>(found->run.id), counted(front.members.size(), "tree"),
               counted(found->run.config.rollout.steps, "step"), to_text(front, picked));
  }
  return {};
}

}  // namespace

void add_front(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("front", "List the trees that none other beats in every measure, pick one");
  command->add_option("STUDY", options->study, "The study file")->required();
  command->add_option("--run", options->run, "Of this run (default: the last that has a front)")
      ->type_name("N")
      ->check(whole_number());
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
  command->add_flag("--json", options->json, "The front as one JSON list");
  command->footer(
      "A rule: best MEASURE [with MEASURE<=NUMBER and ...] [else best ...], with <=, >= or =; shares are from 0 to 1;\n"
      "a measure is one that the run evaluated, nodes, or fitness.\n"
      "Examples:\n"
      "  coppice front uav.coppice --plot front.svg\n"
      "  coppice front uav.coppice --pick 'best return with nodes<=20 and coverage>=0.8' -o best.tree\n"
      "  coppice score uav.coppice --tree best.tree");
  command->callback([&invocation, options] { invocation.chosen = [options] { return front_command(*options); }; });
}

}  // namespace coppice
