#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <vector>

#include "common/chain/exact.hpp"
#include "common/evolution/config.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/standard_input.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/runs/tree_lines.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

constexpr std::size_t kChunk = 1024;  // trees that are read, then evaluated, then answered

struct EvaluateFlags {
  std::string study;
  std::string trees = "-";
  EvaluatorOption evaluator;
  EvolveConfig config;  // seed and rollout only
  std::string acting;
  std::string start;
  bool exact = false;
  std::optional<double> discounted;
  bool long_run = false;
  std::uint32_t generation = 0;
  std::vector<std::string> objectives = {"agreement"};
};

struct Question {
  Job job;
  std::vector<double> units;  // one per objective: value = score / unit
};

Result<Question> question_of(const EvaluateFlags& options, const Chain& chain) {
  EvolveConfig config = options.config;
  const Result<Acting> acting = value_named<Acting>("acting policy", options.acting);
  if (!acting) {
    return in_context("--acting", acting.error());
  }
  config.rollout.acting = *acting;
  const Result<Start> start = value_named<Start>("start", options.start);
  if (!start) {
    return in_context("--start", start.error());
  }
  config.rollout.start = *start;
  RolloutConfig& rollout = config.rollout;
  rollout.method = options.exact        ? Method::exact
                   : options.discounted ? Method::discounted
                   : options.long_run   ? Method::long_run
                                        : Method::rollouts;
  rollout.gamma = options.discounted.value_or(0.0);
  if (!(rollout.gamma >= 0.0 && rollout.gamma <= kMaxGamma)) {
    return bad_input(fmt::format("--discounted is {}: expected 0 to {}", rollout.gamma, kMaxGamma));
  }
  if (rollout.rollouts < 1 || rollout.rollouts > kMaxRollouts) {
    return bad_input(fmt::format("--rollouts is {}: expected 1 to {}", rollout.rollouts, kMaxRollouts));
  }
  if (rollout.steps < 1 || rollout.steps > kMaxSteps) {
    return bad_input(fmt::format("--steps is {}: expected 1 to {}", rollout.steps, kMaxSteps));
  }
  if (rollout.method == Method::rollouts && std::uint64_t{rollout.rollouts} * rollout.steps > kMaxWalkedSteps) {
    return bad_input(fmt::format("--rollouts is {} of {} steps each: expected at most {} steps in all",
                                 rollout.rollouts, rollout.steps, kMaxWalkedSteps));
  }
  if (!(config.rollout.policy_share >= 0.0 && config.rollout.policy_share <= 1.0)) {
    return bad_input(fmt::format("--policy-share is {}: expected 0 to 1", config.rollout.policy_share));
  }
  if (options.generation == kFinalGeneration) {
    return bad_input(fmt::format("--generation is {}: expected 0 to {}", options.generation, kFinalGeneration - 1));
  }
  Question question;
  std::vector<Objective> objectives;
  for (const std::string& name : options.objectives) {
    const Result<ObjectiveKind> kind = value_named<ObjectiveKind>("objective", name);
    if (!kind) {
      return in_context("--objective", kind.error());
    }
    Objective objective{.kind = *kind};
    objective.threshold = *kind == ObjectiveKind::seen         ? options.config.fitness.seen_visits
                          : *kind == ObjectiveKind::collisions ? options.config.fitness.collision_reward
                                                               : 0.0;
    if (*kind == ObjectiveKind::shaped) {
      Result<std::vector<ShapedRule>> rules = thesis_rules(chain.vocabulary());
      if (!rules) {
        return in_context("--objective shaped", std::move(rules).error());
      }
      objective.rules = std::move(*rules);
    }
    const Result<ScoreTable> table = make_score_table(chain, objective);
    if (!table) {
      return in_context(fmt::format("--objective {}", name), table.error());
    }
    question.units.push_back(table->unit);
    objectives.push_back(std::move(objective));
  }
  question.job = job_of(config, std::move(objectives), options.generation);
  if (const Result<void> checked = check_job(question.job); !checked) {
    return tl::unexpected(checked.error());
  }
  return question;
}

std::string answer_of(const Tally& tally, const Question& question) {
  nlohmann::ordered_json objectives = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < tally.scores.size(); ++i) {
    const ObjectiveKind kind = question.job.objectives[i].kind;
    const double value = static_cast<double>(tally.scores[i]) / question.units[i];
    nlohmann::ordered_json& objective = objectives[std::string(name_of(kind))];
    objective = {{"value", value}, {"score", tally.scores[i]}};
    if (along_walk(kind)) {
      objective["per_step"] = tally.steps == 0 ? 0.0 : value / static_cast<double>(tally.steps);
    }
  }
  const double agreement =
      tally.steps == 0 ? 0.0 : static_cast<double>(tally.matches) / static_cast<double>(tally.steps);
  const nlohmann::ordered_json answer = {{"nodes", tally.nodes},
                                         {"matches", tally.matches},
                                         {"steps", tally.steps},
                                         {"agreement", agreement},
                                         {"objectives", objectives}};
  return json_line(answer);
}

// Reads up to kChunk trees. False: the input has ended.
Result<bool> read_chunk(TreeLines& lines, std::vector<Tree>& trees) {
  trees.clear();
  while (trees.size() < kChunk) {
    const Result<TreeLines::Event> event = lines.next();
    if (!event) {
      return tl::unexpected(event.error());
    }
    if (*event == TreeLines::Event::end) {
      return false;
    }
    if (*event == TreeLines::Event::tree) {
      trees.push_back(lines.tree());
    } else if (!trees.empty()) {
      break;
    }
  }
  return true;
}

Result<void> answer_all(TreeLines& lines, Evaluator& evaluator, const Question& question) {
  std::vector<Tree> trees;
  bool more = true;
  while (more) {
    const Result<bool> read = read_chunk(lines, trees);
    if (!read) {
      return tl::unexpected(read.error());
    }
    more = *read;
    if (trees.empty()) {
      continue;
    }
    const Result<std::vector<Tally>> tallies = evaluator.evaluate(trees, question.job);
    if (!tallies) {
      return tl::unexpected(tallies.error());
    }
    for (const Tally& tally : *tallies) {
      fmt::print("{}\n", answer_of(tally, question));
    }
    if (std::fflush(stdout) != 0) {
      return failed(fmt::format("cannot write standard output: {}", std::generic_category().message(errno)));
    }
  }
  return {};
}

Result<void> evaluate_command(const EvaluateFlags& options, const StopFlag& stop) {
  const Result<EvaluatorChoice> choice = evaluator_choice(options.evaluator);
  if (!choice) {
    return tl::unexpected(choice.error());
  }
  const Result<Study> study = Study::open(options.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(study.error());
  }
  const auto chain = std::make_shared<const Chain>(study->chain());
  const Result<Question> question = question_of(options, *chain);
  if (!question) {
    return tl::unexpected(question.error());
  }
  StandardInput standard_input(stop);
  std::filebuf file;
  const bool from_file = options.trees != "-";
  std::error_code error;
  if (from_file && std::filesystem::is_directory(options.trees, error)) {
    return bad_input(fmt::format("--trees {}: is a directory: expected a file of trees, one a line", options.trees));
  }
  if (from_file && file.open(options.trees, std::ios::in) == nullptr) {
    return bad_input(fmt::format("--trees: cannot read {}: {}", options.trees, std::generic_category().message(errno)));
  }
  TreeLines lines(from_file ? static_cast<std::streambuf&>(file) : standard_input,
                  from_file ? options.trees : "standard input", chain->vocabulary());
  const Result<std::unique_ptr<Evaluator>> evaluator = open_evaluator(chain, *choice, stop);
  if (!evaluator) {
    return tl::unexpected(evaluator.error());
  }
  Result<void> answered = answer_all(lines, **evaluator, *question);
  if (answered && stop.raised()) {
    return tl::unexpected(Error{ErrorKind::interrupted, "interrupted before the end of the trees"});
  }
  return answered;
}

}  // namespace

void add_evaluate(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<EvaluateFlags>();
  options->acting = name_of(options->config.rollout.acting);
  options->start = name_of(options->config.rollout.start);
  RolloutConfig& rollout = options->config.rollout;
  CLI::App* command = app.add_subcommand("evaluate", "Evaluate trees: text form in, one a line; JSON out, one a line");
  add_study_argument(*command, options->study);
  command->add_option("--trees", options->trees, "Where the trees are; - is standard input")
      ->type_name("FILE|-")
      ->capture_default_str();
  add_evaluator_option(*command, options->evaluator);
  command->add_option("--rollouts", rollout.rollouts, "Walks through the chain")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--steps", rollout.steps, "Steps per walk")->check(whole_number())->capture_default_str();
  add_seed_option(*command, options->config.seed, "Same seed and generation, same walks");
  command
      ->add_option("--generation", options->generation,
                   "Number of the generation: decides the random numbers, together with the seed")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--acting", options->acting, "Who chooses the steps of a walk")
      ->type_name("tree|policy|mixed")
      ->capture_default_str();
  command
      ->add_option("--policy-share", rollout.policy_share,
                   "With --acting mixed: probability that the policy chooses a step")
      ->capture_default_str();
  CLI::Option* exact = command->add_flag("--exact", options->exact,
                                         "No walks: the expected values over --steps steps, computed, without noise");
  CLI::Option* discounted =
      command
          ->add_option("--discounted", options->discounted,
                       "No walks: expected means per step of an endless walk, step i weighing GAMMA^i (0 to 0.999999)")
          ->type_name("GAMMA");
  CLI::Option* long_run = command->add_flag("--long-run", options->long_run,
                                            "No walks: expected means per step of an endless walk, in the long run");
  exact->excludes(discounted)->excludes(long_run);
  discounted->excludes(long_run);
  command->add_option("--objective", options->objectives, "What to score; may be repeated (default: agreement)")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command
      ->add_option("--seen-visits", options->config.fitness.seen_visits,
                   "Objective seen: fewest visits of a state that counts")
      ->capture_default_str();
  command
      ->add_option("--collision-reward", options->config.fitness.collision_reward,
                   "Objective collisions: a step collides when the mean reward recorded for it is this or less")
      ->capture_default_str();
  command->add_option("--start", options->start, "Where a walk starts")
      ->type_name("initial|visits|uniform")
      ->capture_default_str();
  command->footer(
      "Answers come in the order of the trees: nodes, matches and steps (agreement along the walks), and of every\n"
      "objective its integer score and its value in its own unit, summed over the walks or over all states;\n"
      "along walks also its mean per step. What is computed reads like walks of 8 to 16 million steps in all.\n"
      "Trees are read, checked, evaluated and answered 1024 at a time, so that any number of them will do; a\n"
      "malformed line ends the command (exit code 3) before any tree of its 1024 is evaluated. An empty line ends "
      "such\n"
      "a chunk early: a program that keeps the command running in a pipe sends one to have its answers at once.\n"
      "Example:\n"
      "  echo '(selector (sequence s3=0 turn_left) move)' |\n"
      "    coppice evaluate uav.coppice --serial --objective agreement --objective coverage\n"
      "  coppice evaluate uav.coppice --serial --trees trees.txt --exact --steps 150 --objective return");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return evaluate_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
