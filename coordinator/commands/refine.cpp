#include "coordinator/refine/refine.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <system_error>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/evolve_options.hpp"
#include "coordinator/commands/evolve_progress.hpp"
#include "coordinator/commands/learn_options.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/simulate_option.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/console/progress.hpp"
#include "coordinator/refine/refine_report.hpp"
#include "coordinator/runs/learn_study.hpp"
#include "coordinator/runs/new_folder.hpp"
#include "coordinator/runs/simulate_study.hpp"
#include "coordinator/runs/tree_of_study.hpp"

namespace coppice {
namespace {

struct RefineFlags {
  StudyTreeOption tree;
  std::string folder;
  EvolveOptions evolution;
  EvaluatorOption evaluator;
  std::optional<std::uint64_t> seed;
  std::optional<std::uint32_t> steps;
  RefineSettings settings;
  std::string simulator;
  bool json = false;
};

// Progress of the walks of one round, then of its evolution, each a line of its own.
class Shown {
 public:
  explicit Shown(std::uint64_t episodes) : episodes_(episodes) {}

  void walking(std::uint32_t round) {
    done_ = 0;
    progress_.emplace(stderr, progress_settings_for(stderr), fmt::format("round {}, walk", round), "episodes",
                      episodes_);
  }
  void episode() {
    if (progress_) {
      progress_->update(++done_);
    }
  }
  void ended() { progress_.reset(); }

 private:
  std::uint64_t episodes_;
  std::uint64_t done_ = 0;
  std::optional<Progress> progress_;
};

Result<void> refine_command(const RefineFlags& options, const StopFlag& stop) {
  const Result<EvaluatorChoice> evaluator = evaluator_choice(options.evaluator);
  if (!evaluator) {
    return tl::unexpected(evaluator.error());
  }
  const Result<StudyTree> given = open_study_tree(options.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  const Result<World> world = world_of(study, options.simulator);
  if (!world) {
    return tl::unexpected(world.error());
  }
  const Vocabulary& vocabulary = study.chain().vocabulary();
  if (vocabulary != vocabulary_of(*world)) {
    return bad_input(fmt::format(
        "{}: the chain's features and actions are not those of its world: nothing can be simulated", study.path()));
  }
  const std::optional<RunId> run = options.tree.run ? std::optional(RunId{*options.tree.run}) : std::nullopt;
  const auto base = config_of_run(study, run);
  if (!base) {
    return tl::unexpected(base.error());
  }
  const Result<EvolveConfig> config =
      evolve_config(options.evolution, options.seed, {.vocabulary = vocabulary, .base = *base ? &**base : nullptr});
  if (!config) {
    return tl::unexpected(config.error());
  }
  RefineSettings settings = options.settings;
  settings.walks.steps = options.steps ? *options.steps : learned_steps(study);
  settings.walks.seed = config->seed;
  settings.walks.stop = &stop;
  settings.judged.steps = settings.walks.steps;
  settings.judged.stop = &stop;
  if (const Result<void> checked = check_settings(settings); !checked) {
    return checked;
  }
  if (const Result<void> checked = check_choice(*evaluator); !checked) {
    return checked;
  }
  const Result<std::filesystem::path> folder = new_folder(options.folder, "coppice-refine");
  if (!folder) {
    return tl::unexpected(folder.error());
  }

  std::vector<RefineRound> rounds;
  Shown shown(settings.walks.episodes);
  RefineHooks hooks;
  hooks.walking = [&](std::uint32_t round) { shown.walking(round); };
  hooks.go_on = [&] {
    shown.episode();
    return !stop.raised();
  };
  hooks.evolve = [&](Study& round, const EvolveConfig& round_config) -> Result<RoundAnswer> {
    shown.ended();
    const auto report = evolve_shown(round, {.config = round_config, .resumed = std::nullopt, .evaluator = *evaluator},
                                     options.evolution.lines_every, stop);
    return report ? Result<RoundAnswer>(RoundAnswer{report->tree(), report->interrupted()})
                  : tl::unexpected(report.error());
  };
  hooks.round_done = [&](const RefineRound& round) { rounds.push_back(round); };
  const Result<void> refined = refine(study, *world, tree, *config, settings, *folder, hooks);
  shown.ended();

  const std::optional<std::size_t> best = best_of(rounds);
  std::error_code ignored;
  std::filesystem::remove(*folder, ignored);  // only if it is empty
  if (options.json) {
    fmt::print("{}\n", json_line({{"folder", folder->string()},
                                  {"best_round", best ? nlohmann::ordered_json(rounds[*best].round) : nullptr},
                                  {"rounds", to_json(rounds)}}));
  } else if (!rounds.empty()) {
    fmt::print("{}", to_text(rounds));
    if (best) {
      fmt::print("its study: {}\n", rounds[*best].study);
    }
  }
  if (!refined) {
    return tl::unexpected(
        Error{refined.error().kind, fmt::format("{}; the rounds before are kept", refined.error().message)});
  }
  return keep_simulator(options.tree.study, options.simulator);
}

}  // namespace

void add_refine(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<RefineFlags>();
  CLI::App* command = app.add_subcommand(
      "refine", "Walk the best tree in the simulator, count what it meets into the chain, evolve on, and again");
  add_study_tree(*command, options->tree);
  command
      ->add_option("-o,--output", options->folder,
                   "The folder to make, with a study for each round (default: coppice-refine-<UTC time>)")
      ->type_name("FOLDER");
  command->add_option("--rounds", options->settings.rounds, "Rounds of walking and evolving")
      ->type_name("R")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--episodes", options->settings.walks.episodes, "Episodes that the tree walks in each round")
      ->type_name("E")
      ->check(whole_number())
      ->capture_default_str();
  add_simulator(*command, options->simulator);
  command->add_option("--steps", options->steps, "Steps per episode (default: as in learning)")->check(whole_number());
  command
      ->add_option("--score-episodes", options->settings.judged.episodes,
                   "Episodes in the simulator that judge each round's tree; no round walks them")
      ->check(whole_number())
      ->capture_default_str();
  add_evaluator_option(*command, options->evaluator);
  add_evolve_options(*command, options->evolution);
  add_seed_option(*command, options->seed,
                  "Seed of the walks; round r evolves with r more (default: seed of --config, or of the run)");
  add_json_flag(*command, options->json);
  command->footer(
      "Every round's study, round-1.coppice and so on, is as good as any: score it, verify it, evolve it further.\n"
      "Evolution is set up as the refined run was (the last one with --tree), or by --config. It begins with the tree\n"
      "that was walked, the best so far and the front that it is on. The answer is the best round: fewest collisions,\n"
      "then the highest reward in the simulator. The given study is not changed.\n"
      "Ctrl-C keeps every round that has ended, and the best so far of the one under way (exit code 4).\n"
      "Examples:\n"
      "  coppice refine uav.coppice -o refined --config coordinator/evolution/front.toml --workers 2\n"
      "  coppice refine uav.coppice --rounds 5 --episodes 100000 --serial --seed 3\n"
      "  coppice score refined/round-3.coppice");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return refine_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
