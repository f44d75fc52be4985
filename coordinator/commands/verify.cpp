#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <optional>

#include "common/chain/exact.hpp"
#include "common/tree/text.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/simulate_option.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/console/progress.hpp"
#include "coordinator/report/score.hpp"
#include "coordinator/runs/simulate_study.hpp"
#include "coordinator/trust/verification_report.hpp"

namespace coppice {
namespace {

struct VerifyFlags {
  StudyTreeOption tree;
  std::vector<std::string> rules;
  std::string rule_file;
  bool keep = false;
  std::vector<std::string> events;
  SimulateOption simulate;  // its steps and seed are those of the chain too
  std::uint32_t resamples = VerifySettings{}.resamples;
  std::uint64_t bound = 20'000;
  bool json = false;
};

// Those that were given, or else those that the study keeps.
Result<std::vector<Rule>> rules_of(const VerifyFlags& options, const Study& study) {
  const Vocabulary& vocabulary = study.chain().vocabulary();
  std::vector<Rule> rules;
  if (options.rules.empty() && options.rule_file.empty()) {
    for (const std::string& text : study.problem().rules) {
      Result<Rule> rule = parse_rule(text, vocabulary);
      if (!rule) {
        return in_context(fmt::format("{}: the rule that it keeps, '{}'", study.path(), text), std::move(rule).error());
      }
      rules.push_back(std::move(*rule));
    }
    return rules;
  }
  for (const std::string& text : options.rules) {
    Result<Rule> rule = parse_rule(text, vocabulary);
    if (!rule) {
      return in_context(fmt::format("--rule '{}'", text), std::move(rule).error());
    }
    rules.push_back(std::move(*rule));
  }
  if (!options.rule_file.empty()) {
    Result<std::vector<Rule>> read = read_rules(options.rule_file, vocabulary);
    if (!read) {
      return tl::unexpected(std::move(read).error());
    }
    rules.insert(rules.end(), read->begin(), read->end());
  }
  return rules;
}

// For the next time: the study then has them, beside those that it has.
Result<void> keep_rules(const std::string& path, const std::vector<Rule>& rules) {
  Result<Study> study = Study::open(path);
  if (!study) {
    return tl::unexpected(std::move(study).error());
  }
  return study->change_problem([&](Problem& problem) -> Result<void> {
    for (const Rule& rule : rules) {
      if (rule.text.size() > kMaxRule) {
        return bad_input(
            fmt::format("--keep: a rule has {} characters: expected at most {}", rule.text.size(), kMaxRule));
      }
      if (std::find(problem.rules.begin(), problem.rules.end(), rule.text) != problem.rules.end()) {
        continue;
      }
      if (problem.rules.size() == kMaxRules) {
        return bad_input(fmt::format("--keep: {} keeps {} rules: expected no more", path, kMaxRules));
      }
      problem.rules.push_back(rule.text);
    }
    return {};
  });
}

Result<std::vector<Event>> events_of(const VerifyFlags& options, const Study& study) {
  if (options.events.empty()) {
    return events_of_world(study.world().kind);
  }
  std::vector<Event> events;
  for (const std::string& text : options.events) {
    Result<Event> event = parse_event(text);
    if (!event) {
      return in_context("--event", std::move(event).error());
    }
    events.push_back(std::move(*event));
  }
  return events;
}

Result<void> verify_command(const VerifyFlags& options, const StopFlag& stop) {
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  const Chain& chain = study.chain();
  const Result<std::vector<Rule>> rules = rules_of(options, study);
  if (!rules) {
    return tl::unexpected(rules.error());
  }
  if (options.keep) {
    if (options.rules.empty() && options.rule_file.empty()) {
      return bad_input("--keep without --rule or --rules: expected a rule to keep");
    }
    if (const Result<void> kept = keep_rules(options.tree.study, *rules); !kept) {
      return kept;
    }
  }
  const Result<std::vector<Event>> events = events_of(options, study);
  if (!events) {
    return tl::unexpected(events.error());
  }
  const SimulateSettings simulate = settings_of(options.simulate, study);
  const VerifySettings settings{.steps = simulate.steps, .resamples = options.resamples, .seed = options.simulate.seed};
  if (const Result<void> checked = check_settings(settings); !checked) {
    return checked;
  }
  std::vector<CheckedRule> answers;
  for (const Rule& rule : *rules) {
    Result<CheckedRule> answer = check_on(rule, tree, chain);
    if (!answer) {
      return tl::unexpected(std::move(answer).error());
    }
    answers.push_back(std::move(*answer));
  }
  std::optional<Simulated> beside;
  if (options.simulate.episodes > 0) {
    const auto episodes = simulated(study, tree, simulate, options.simulate.simulator, stop);
    if (!episodes) {
      return tl::unexpected(episodes.error());
    }
    if (const Result<void> kept = keep_simulator(options.tree.study, options.simulate.simulator); !kept) {
      return kept;
    }
    beside = *episodes ? std::optional(sum_up(**episodes)) : std::nullopt;
  }
  Progress progress(stderr, progress_settings_for(stderr), "verify", "draws", settings.resamples);
  const Result<Verification> verification =
      verify(chain, tree, *events, rewards_of_world(study.world().kind), settings, [&](std::uint32_t done) {
        progress.update(done);
        return !stop.raised();
      });
  if (!verification) {
    return tl::unexpected(verification.error());
  }
  std::optional<SizeBound> bound;
  if (const auto discount = study.problem().discount; discount && *discount <= kMaxGamma && options.bound > 0) {
    auto found = bound_of_size(chain, tree, *discount, options.bound, [&] { return !stop.raised(); });
    if (!found) {
      return tl::unexpected(found.error());
    }
    bound = *found;
  }
  std::size_t broken = 0;
  nlohmann::ordered_json json = {{"tree", to_text(tree, chain.vocabulary())}};
  json.update(to_json(*verification, beside));
  if (bound) {
    json["of_its_size"] = to_json(*bound);
  }
  json["rules"] = nlohmann::ordered_json::array();
  std::string text = to_text(*verification, beside) + (bound ? to_text(*bound) : std::string());
  for (const CheckedRule& answer : answers) {
    broken += answer.answer.holds() ? 0U : 1U;
    json["rules"].push_back(to_json(answer, tree, chain));
    text += '\n' + to_text(answer, tree, chain, study.problem());
  }
  fmt::print("{}", options.json ? json_line(json) + '\n' : text);
  if (!options.json) {
    print_legend(tree, study);
  }
  if (broken > 0) {
    return failed(fmt::format("the tree breaks {} of {}", broken, counted(answers.size(), "rule")));
  }
  return {};
}

}  // namespace

void add_verify(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<VerifyFlags>();
  CLI::App* command =
      app.add_subcommand("verify", "What a tree promises: exact figures with intervals, and rules proved");
  add_study_tree(*command, options->tree);
  command->add_option("--rule", options->rules, "Prove this for every possible observation; may be repeated")
      ->type_name("RULE")
      ->allow_extra_args(false);
  command->add_option("--rules", options->rule_file, "The same for a file of rules, one a line")->type_name("FILE");
  command->add_flag("--keep", options->keep,
                    "Keep these rules in the study: later calls without a rule prove them, as report and studio do");
  command
      ->add_option("--event", options->events,
                   "What to count, instead of the world's own events: a test of a pair's mean reward; may be repeated")
      ->type_name("NAME:reward<=NUMBER")
      ->allow_extra_args(false);
  command->add_option("--resamples", options->resamples, "Draws from the counts' posterior behind an interval")
      ->check(whole_number())
      ->capture_default_str();
  command
      ->add_option(
          "--bound", options->bound,
          "Where the problem was solved with a discount: look for the most that a tree of so many conditions can "
          "earn, by so many solutions at most; 0: not")
      ->check(whole_number())
      ->capture_default_str();
  add_simulate_option(
      *command, options->simulate,
      {.episodes = "Episodes in the simulator, shown beside; 0: none", .seed = "Of the draws and the simulator"});
  add_json_flag(*command, options->json);
  command->footer(
      "Without a rule given it proves those that the study keeps ('coppice info' lists them).\n"
      "A rule is 'never ACTION when CONDITION' or 'always ACTION when CONDITION'; 'or' joins actions, 'and' and\n"
      "'or' join tests (s3=0, s3!=0, x<=4), 'none' is no action. Ends with 1 when a rule is broken.\n"
      "Examples:\n"
      "  coppice verify uav.coppice --rule 'never move when s3=0'\n"
      "  coppice verify uav.coppice --tree best.tree --rules safety.rules --json\n"
      "  coppice verify uav.coppice --event 'crash:reward<=-10' --steps 1000");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return verify_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
