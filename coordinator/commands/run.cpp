#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/evolve_options.hpp"
#include "coordinator/commands/evolve_progress.hpp"
#include "coordinator/commands/learn_options.hpp"
#include "coordinator/commands/page_options.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/console/whole_file.hpp"
#include "coordinator/fleet/open_evaluator.hpp"
#include "coordinator/report/draw.hpp"
#include "coordinator/report/score.hpp"
#include "coordinator/runs/evolve_report.hpp"
#include "coordinator/runs/new_folder.hpp"

namespace coppice {
namespace {

constexpr std::uint64_t kDefaultSeed = 1;

struct RunFlags {
  std::string folder;  // empty: named by the time
  LearnOptions learning;
  EvolveOptions evolution;
  EvaluatorOption evaluator;
  std::optional<std::uint64_t> seed;
  std::uint64_t score_episodes = SimulateSettings{}.episodes;
  bool json = false;
};

Result<void> write_drawings(const Tree& tree, const Study& study, const std::filesystem::path& stem) {
  for (const char* extension : {".dot", ".svg"}) {
    std::filesystem::path path = stem;
    path += extension;
    if (const Result<void> written = write_drawing(tree, study.chain().vocabulary(), study.problem(), path); !written) {
      return written;
    }
  }
  return {};
}

Result<void> write_reports(const std::filesystem::path& folder, const EvolveReport& evolved, const Score& score,
                           const Study& study) {
  if (const auto written = write_whole_file(folder / "table-iv.txt", to_text(score)); !written) {
    return written;
  }
  if (const auto written = write_whole_file(folder / "table-iv.json", to_json(score) + "\n"); !written) {
    return written;
  }
  if (const auto written = write_drawings(evolved.tree(), study, folder / "evolved"); !written) {
    return written;
  }
  return write_drawings(evolved.pruned, study, folder / "pruned");
}

tl::unexpected<Error> interrupted(const std::string& hint) {
  return tl::unexpected(Error{ErrorKind::interrupted, fmt::format("interrupted; {}", hint)});
}

// Everything after evolution; prints it, or, if `json` is an object, puts it there.
Result<void> score_and_draw(const LearnTask& learning, const Study& study, const EvolveReport& evolved,
                            const SimulateSettings& settings, const std::filesystem::path& folder, const StopFlag& stop,
                            nlohmann::ordered_json& json) {
  const Result<Score> score =
      score_tree(learning.world, study.chain(), evolved.tree(), settings, [&] { return !stop.raised(); });
  if (!score) {
    return score.error().kind == ErrorKind::interrupted
               ? interrupted(fmt::format("the run is complete, score it with: coppice score {}", study.path()))
               : tl::unexpected(score.error());
  }
  if (json.is_object()) {
    json["score"] = nlohmann::ordered_json::parse(to_json(*score));
  } else {
    fmt::print("{}\n", to_text(*score));
  }
  if (const Result<void> written = write_reports(folder, evolved, *score, study); !written) {
    return written;
  }
  const std::string report = (folder / "report.html").string();
  PageOptions page;
  page.tree.study = study.path();
  page.tree.run = static_cast<std::int64_t>(evolved.run);
  page.simulate = {.episodes = settings.episodes, .steps = settings.steps, .seed = settings.seed};
  if (const Result<void> written = write_report(page_request(page, study, evolved.tree(), report), study, report, stop);
      !written) {
    return written.error().kind == ErrorKind::interrupted
               ? interrupted(fmt::format("the run is complete, make its report with: coppice report {} -o {}",
                                         study.path(), report))
               : written;
  }
  if (json.is_object()) {
    json["report"] = report;
  } else {
    fmt::print("drawings: {}, {}\nstudy: {}\n", (folder / "evolved.svg").string(), (folder / "pruned.svg").string(),
               study.path());
    fmt::print("report, to open in a browser: {}\n", report);
  }
  return {};
}

Result<void> run_command(const RunFlags& options, const StopFlag& stop) {
  // Everything that can be wrong with the flags is found before the folder exists.
  const Result<LearnTask> learning = learn_task(options.learning, options.seed.value_or(kDefaultSeed));
  if (!learning) {
    return tl::unexpected(learning.error());
  }
  const Result<EvolveConfig> config = evolve_config(options.evolution, options.seed, {vocabulary_of(learning->world)});
  if (!config) {
    return tl::unexpected(config.error());
  }
  const Result<EvaluatorChoice> evaluator = evaluator_choice(options.evaluator);
  if (!evaluator) {
    return tl::unexpected(evaluator.error());
  }
  if (const Result<void> checked = check_choice(*evaluator); !checked) {
    return checked;
  }
  const SimulateSettings settings{.episodes = options.score_episodes,
                                  .steps = learning->settings.steps,
                                  .seed = options.seed.value_or(kDefaultSeed)};
  if (const Result<void> checked = check_score_settings(settings, "--score-episodes"); !checked) {
    return checked;
  }
  if (const Result<void> found = check_dot(); !found) {
    return found;
  }
  const Result<std::filesystem::path> folder = new_folder(options.folder, "coppice-run");
  if (!folder) {
    return tl::unexpected(folder.error());
  }
  const std::string study_path = (*folder / "study.coppice").string();
  Result<LearnReport> learned = learn_shown(*learning, study_path, stop);
  if (!learned) {
    std::error_code ignored;
    std::filesystem::remove(*folder, ignored);  // only if it is empty
    return tl::unexpected(std::move(learned).error());
  }
  Study& study = learned->study;
  if (!options.json) {
    fmt::print("{}\n", learned->text);
    static_cast<void>(std::fflush(stdout));  // what could not be printed is found at the end
  }
  const Result<EvolveReport> evolved =
      evolve_shown(study, {.config = *config, .resumed = std::nullopt, .evaluator = *evaluator},
                   options.evolution.lines_every, stop);
  if (!evolved) {
    return in_context(study_path, evolved.error());
  }
  if (!options.json) {
    fmt::print("{}\n", to_text(*evolved, study));
    static_cast<void>(std::fflush(stdout));
  }
  nlohmann::ordered_json json;
  if (options.json) {
    json = {{"folder", folder->string()},
            {"learn", nlohmann::ordered_json::parse(learned->json)},
            {"evolve", nlohmann::ordered_json::parse(to_json(*evolved, study))},
            {"score", nullptr}};
  }
  const Result<void> reported = evolved->interrupted()
                                    ? interrupted(resume_hint(study))
                                    : score_and_draw(*learning, study, *evolved, settings, *folder, stop, json);
  if (options.json) {
    fmt::print("{}\n", json_line(json));
  }
  return reported;
}

}  // namespace

void add_run(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<RunFlags>();
  CLI::App* command =
      app.add_subcommand("run", "From nothing to a drawn tree: learn, evolve, score and draw, into a new folder");
  command->add_option("-o,--output", options->folder, "The folder to make (default: coppice-run-<UTC time>)")
      ->type_name("FOLDER");
  add_learn_options(*command, options->learning);
  add_evaluator_option(*command, options->evaluator);
  add_evolve_options(*command, options->evolution);
  add_seed_option(*command, options->seed, "Seed of learning, evolution and simulator (default: 1)");
  command->add_option("--score-episodes", options->score_episodes, "Episodes in the simulator for Table IV")
      ->check(whole_number())
      ->capture_default_str();
  add_json_flag(*command, options->json);
  command->footer(
      "Writes study.coppice, report.html, evolved.svg, pruned.svg (and .dot), table-iv.txt and table-iv.json; never\n"
      "overwrites.\n"
      "Examples:\n"
      "  coppice run --workers 2\n"
      "  coppice run -o trial --episodes 20000 --set ga.generations=100 --serial --seed 3");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return run_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
