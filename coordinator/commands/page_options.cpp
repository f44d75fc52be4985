#include "coordinator/commands/page_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>

#include "common/tree/simplify.hpp"
#include "coordinator/bench/machine.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/progress.hpp"
#include "coordinator/console/whole_file.hpp"
#include "coordinator/studio/page_file.hpp"
#include "coordinator/studio/page_trust.hpp"
#include "coordinator/studio/shell_word.hpp"

namespace coppice {
namespace {

std::string source_of(const StudyTreeOption& option, std::size_t nodes, std::size_t pruned) {
  if (!option.tree.empty()) {
    return "--tree";
  }
  const std::string run = option.run ? fmt::format("run {}", *option.run) : std::string("the last finished run");
  return pruned == nodes ? run : fmt::format("{}, pruned from {}", run, counted(nodes, "node"));
}

std::string command_of(const PageOptions& options, const std::string& output) {
  std::string text = output.empty() ? "coppice studio " : "coppice report ";
  text += shell_word(options.tree.study);
  if (!options.tree.tree.empty()) {
    text += " --tree " + shell_word(options.tree.tree);
  }
  if (options.tree.run) {
    text += fmt::format(" --run {}", *options.tree.run);
  }
  for (const std::string& rule : options.rules) {
    text += " --rule " + shell_word(rule);
  }
  if (options.simulate.episodes != SimulateSettings{}.episodes) {
    text += fmt::format(" --episodes {}", options.simulate.episodes);
  }
  if (options.simulate.steps) {
    text += fmt::format(" --steps {}", *options.simulate.steps);
  }
  if (!options.simulate.simulator.empty()) {
    text += " --simulator " + shell_word(options.simulate.simulator);
  }
  if (options.simulate.seed != SimulateSettings{}.seed) {
    text += fmt::format(" --seed {}", options.simulate.seed);
  }
  return output.empty() ? text : text + " -o " + shell_word(output);
}

}  // namespace

void add_page_options(CLI::App& command, PageOptions& options) {
  add_study_tree(command, options.tree);
  command.add_option("--rule", options.rules, "Prove this too, for every possible observation; may be repeated")
      ->type_name("RULE")
      ->allow_extra_args(false);
  command.add_option("--resamples", options.resamples, "Draws from the counts' posterior behind an interval; 0: none")
      ->check(whole_number())
      ->capture_default_str();
  add_simulate_option(command, options.simulate);
}

PageRequest page_request(const PageOptions& options, const Study& study, const Tree& tree, const std::string& output) {
  const bool as_it_is = !options.tree.tree.empty();
  Tree shown = as_it_is ? tree : simplify(tree, study.chain().vocabulary()).tree;
  const std::size_t nodes = shown.size();
  std::vector<std::string> rules = default_rules(study.world().kind);
  for (const std::vector<std::string>* more : {&study.problem().rules, &options.rules}) {
    for (const std::string& rule : *more) {
      if (std::find(rules.begin(), rules.end(), rule) == rules.end()) {
        rules.push_back(rule);
      }
    }
  }
  const Machine machine = this_machine();
  return {.tree = std::move(shown),
          .tree_from = source_of(options.tree, tree.size(), nodes),
          .simulate = settings_of(options.simulate, study),
          .resamples = options.resamples,
          .simulator = options.simulate.simulator,
          .rules = std::move(rules),
          .machine = fmt::format("{}, {}, {}", machine.processor, counted(machine.cores, "core"), machine.system),
          .command = command_of(options, output)};
}

Result<nlohmann::ordered_json> page_data_shown(const PageRequest& request, const Study& study, const StopFlag& stop) {
  Progress progress(stderr, progress_settings_for(stderr), "report", "%", 100);
  PageRequest stopped_by = request;
  stopped_by.simulate.stop = &stop;
  return page_data(study, stopped_by, [&](double share) {
    progress.update(static_cast<std::uint64_t>(100.0 * share));
    return !stop.raised();
  });
}

Result<void> write_report(const PageRequest& request, const Study& study, const std::string& output,
                          const StopFlag& stop) {
  const Result<nlohmann::ordered_json> data = page_data_shown(request, study, stop);
  if (!data) {
    return tl::unexpected(data.error());
  }
  return write_whole_file(output, report_page(*data));
}

}  // namespace coppice
