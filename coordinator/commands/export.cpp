#include <CLI/CLI.hpp>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <vector>

#include "common/tree/action_table.hpp"
#include "common/tree/guard.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/text.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/output_option.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/whole_file.hpp"
#include "coordinator/exchange/behavior_tree_xml.hpp"
#include "coordinator/exchange/cpp_header.hpp"
#include "coordinator/exchange/drn_writer.hpp"
#include "coordinator/exchange/dtcontrol.hpp"
#include "coordinator/exchange/prism_explicit.hpp"
#include "coordinator/exchange/py_trees_code.hpp"
#include "coordinator/exchange/python_function.hpp"
#include "coordinator/exchange/tikz.hpp"
#include "coordinator/exchange/tree_json.hpp"
#include "coordinator/report/draw.hpp"
#include "coordinator/trust/events.hpp"

namespace coppice {
namespace {

struct ExportFlags {
  StudyTreeOption tree;
  std::string format;
  OutputOption output;
  std::vector<std::string> events;
  bool as_given = false;
};

enum class About : std::uint8_t { tree, guarded_tree, chain_under_tree, chain };

struct Format {
  const char* name;
  const char* extension;  // chosen by it without --format; empty: never
  About about;            // guarded_tree: no other form can be written
  const char* what;
};

constexpr Format kFormats[] = {
    {"behaviortree", ".xml", About::tree, "XML of BehaviorTree.CPP 4, scripts: runs in a stock executor"},
    {"behaviortree-nodes", "", About::guarded_tree, "the same with nodes that the robot registers, and their model"},
    {"cpp", ".hpp", About::guarded_tree, "a C++17 header without dependencies"},
    {"python", ".py", About::guarded_tree, "a Python file with action(observation)"},
    {"py-trees", "", About::tree, "a Python file for py_trees"},
    {"json", ".json", About::tree, "JSON, also for coppice.Tree.load of the Python package"},
    {"text", ".tree", About::tree, "our own text form"},
    {"dot", ".dot", About::tree, "Graphviz"},
    {"tikz", ".tex", About::tree, "LaTeX, a drawing by TikZ"},
    {"drn", ".drn", About::chain, "Storm: the counted chain, an MDP"},
    {"drn-intervals", "", About::chain, "the same, with 95 % intervals for the counts"},
    {"drn-tree", "", About::chain_under_tree, "Storm: the Markov chain that the tree makes of it"},
    {"drn-tree-intervals", "", About::chain_under_tree, "the same, with 95 % intervals for the counts"},
    {"prism", ".tra", About::chain, "PRISM's explicit files: .tra, .sta, .lab and rewards, side by side"},
    {"prism-tree", "", About::chain_under_tree, "the same for the Markov chain that the tree makes"},
    {"dtcontrol", ".csv", About::chain, "the learned policy for dtControl"},
};

std::string format_names() {
  std::string names;
  for (const Format& format : kFormats) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", format.name);
  }
  return names;
}

Result<const Format*> format_of(const ExportFlags& options) {
  const std::string extension = std::filesystem::path(options.output.path).extension().string();
  for (const Format& format : kFormats) {
    if (options.format.empty() ? (!extension.empty() && extension == format.extension)
                               : options.format == format.name) {
      return &format;
    }
  }
  if (options.format.empty()) {
    return bad_input(fmt::format("-o {}: its extension says no format: expected --format, one of {}",
                                 options.output.path, format_names()));
  }
  return bad_input(fmt::format("--format {}: expected one of {}", options.format, format_names()));
}

bool to_standard_output(const ExportFlags& options) { return options.output.path == "-"; }

Result<void> check_target(const ExportFlags& options, const std::string& path) {
  return check_output("-o", path, options.output.force, options.tree.study);
}

Result<void> write(const ExportFlags& options, const std::string& path,
                   const std::function<void(std::ostream&)>& fill) {
  if (to_standard_output(options)) {
    fill(std::cout);
    return {};
  }
  return write_whole_file(path, fill);
}

std::string origin_of(const ExportFlags& options) {
  const std::string study = std::filesystem::path(options.tree.study).filename().string();
  if (options.tree.run) {
    return fmt::format("{}, run {}", study, *options.tree.run);
  }
  return options.tree.tree.empty() ? study : study + ", given";
}

Result<std::string> tree_text(const Format& format, const ExportedTree& exported) {
  const std::string_view name = format.name;
  if (name == "behaviortree") {
    return to_behavior_tree_xml(exported, BehaviorTreeStyle::scripts);
  }
  if (name == "behaviortree-nodes") {
    return to_behavior_tree_xml(exported, BehaviorTreeStyle::nodes);
  }
  if (name == "cpp") {
    return to_cpp_header(exported);
  }
  if (name == "python") {
    return to_python_function(exported);
  }
  if (name == "py-trees") {
    return to_py_trees_code(exported);
  }
  if (name == "json") {
    return to_tree_json(exported);
  }
  if (name == "dot") {
    return to_dot(exported.tree, exported.vocabulary, exported.problem);
  }
  if (name == "tikz") {
    return to_tikz(exported);
  }
  return to_text(exported.tree, exported.vocabulary) + '\n';
}

Result<void> export_tree(const ExportFlags& options, const Format& format, const Study& study) {
  const Result<Tree> given = study_tree(options.tree, study);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const Vocabulary& vocabulary = study.chain().vocabulary();
  if (options.as_given && format.about == About::guarded_tree && !is_guarded(*given)) {
    return bad_input(
        fmt::format("--as-given: the tree acts before it asks, which {} cannot say: expected the guarded "
                    "form, as without --as-given",
                    format.name));
  }
  const Result<Tree> tree = options.as_given ? given : guard(*given, vocabulary);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  const Result<std::string> text = tree_text(format, {*tree, vocabulary, study.problem(), origin_of(options)});
  if (!text) {
    return tl::unexpected(text.error());
  }
  if (const Result<void> written = write(options, options.output.path, [&](std::ostream& out) { out << *text; });
      !written) {
    return written;
  }
  if (!to_standard_output(options)) {
    const std::string size =
        options.as_given ? counted(tree->size(), "node")
                         : fmt::format("{} in guarded form, {} as given", counted(tree->size(), "node"), given->size());
    fmt::print("wrote {} ({}): {}\n", options.output.path, format.name, size);
  }
  return {};
}

// States in which what the tree does is the event for certain.
Result<std::vector<StateLabel>> labels_of(const ExportFlags& options, const Study& study, const Tree& tree) {
  std::vector<Event> events = options.events.empty() ? events_of_world(study.world().kind) : std::vector<Event>();
  for (const std::string& text : options.events) {
    Result<Event> event = parse_event(text);
    if (!event) {
      return in_context("--event", std::move(event).error());
    }
    if (event->name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") !=
        std::string::npos) {
      return bad_input(fmt::format("--event {}: expected a name of letters, digits and _", text));
    }
    for (const char* taken : {"init", "deadlock", "terminal", "unknown", "start"}) {
      if (event->name == taken) {
        return bad_input(fmt::format("--event {}: the name has a meaning of its own: expected another", text));
      }
    }
    events.push_back(std::move(*event));
  }
  const Chain& chain = study.chain();
  const std::vector<ActionId> table = action_table(tree, StateColumns(chain.vocabulary(), chain.parts().features));
  std::vector<StateLabel> labels;
  for (const Event& event : events) {
    const EventPairs pairs = pairs_of(event, chain, rewards_of_world(study.world().kind));
    StateLabel label{event.name, std::vector<bool>(chain.states(), false)};
    for (std::size_t state = 0; state < chain.states(); ++state) {
      const std::size_t taken =
          chain.taken(state, table[state] == kNoAction ? chain.actions() : index_of(table[state]));
      label.holds[state] = pairs.chance[state * (chain.actions() + 1) + taken] == 1.0;
    }
    labels.push_back(std::move(label));
  }
  return labels;
}

Result<void> export_model(const ExportFlags& options, const Format& format, const Study& study) {
  std::optional<Tree> tree;
  std::vector<StateLabel> labels;
  if (format.about == About::chain_under_tree) {
    Result<Tree> given = study_tree(options.tree, study);
    if (!given) {
      return tl::unexpected(std::move(given).error());
    }
    tree = std::move(*given);
    Result<std::vector<StateLabel>> found = labels_of(options, study, *tree);
    if (!found) {
      return tl::unexpected(std::move(found).error());
    }
    labels = std::move(*found);
  }
  const std::string_view name = format.name;
  if (name == "dtcontrol") {
    return write(options, options.output.path, [&](std::ostream& out) { write_dtcontrol(study.chain(), out); });
  }
  const MarkovModel model(study.chain(), tree ? &*tree : nullptr, std::move(labels));
  if (name != "prism" && name != "prism-tree") {
    const bool intervals = name == "drn-intervals" || name == "drn-tree-intervals";
    return write(options, options.output.path, [&](std::ostream& out) { write_drn(model, intervals, out); });
  }
  if (to_standard_output(options)) {
    return bad_input("-o -: a PRISM model is several files: expected a file name");
  }
  const std::filesystem::path stem = std::filesystem::path(options.output.path).replace_extension();
  const std::vector<PrismPart> parts = prism_parts(model);
  for (const PrismPart& part : parts) {
    if (const Result<void> target = check_target(options, stem.string() + part.extension); !target) {
      return target;
    }
  }
  for (const PrismPart& part : parts) {
    const Result<void> written = write_whole_file(stem.string() + part.extension,
                                                  [&](std::ostream& out) { write_prism(model, part.file, out); });
    if (!written) {
      return written;
    }
  }
  return {};
}

Result<void> export_command(const ExportFlags& options) {
  const Result<const Format*> format = format_of(options);
  if (!format) {
    return tl::unexpected(format.error());
  }
  if (!to_standard_output(options)) {
    if (const Result<void> target = check_target(options, options.output.path); !target) {
      return target;
    }
  }
  const Result<Study> study = Study::open(options.tree.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(study.error());
  }
  const bool of_tree = (*format)->about == About::tree || (*format)->about == About::guarded_tree;
  return of_tree ? export_tree(options, **format, *study) : export_model(options, **format, *study);
}

}  // namespace

void add_export(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<ExportFlags>();
  CLI::App* command = app.add_subcommand("export", "Write a tree, or the chain, for other programs");
  add_study_tree(*command, options->tree);
  add_output_option(*command, options->output, "The file; '-' is standard output")->required();
  command->add_option("--format", options->format, "One of the names below (default: told by the file's extension)")
      ->type_name("NAME");
  command->add_flag("--as-given", options->as_given,
                    "The tree as it is, not in guarded form: it may then act before it asks");
  command
      ->add_option("--event", options->events,
                   "Formats of the chain under a tree: label the states in which the tree's action is this, instead of "
                   "the world's own events; may be repeated")
      ->type_name("NAME:reward<=NUMBER")
      ->allow_extra_args(false);
  std::string footer =
      "Trees are written in guarded form (see 'coppice prune --guarded'), equal in every state.\n"
      "Formats:\n";
  for (const Format& format : kFormats) {
    footer += fmt::format("  {:<20}{:<6}{}\n", format.name, format.extension, format.what);
  }
  command->footer(footer +
                  "Examples:\n"
                  "  coppice export uav.coppice -o policy.xml\n"
                  "  coppice export uav.coppice --run 3 -o policy.hpp\n"
                  "  coppice export uav.coppice --format drn-tree -o tree.drn");
  command->callback([&invocation, options] { invocation.chosen = [options] { return export_command(*options); }; });
}

}  // namespace coppice
