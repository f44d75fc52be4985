#include "coordinator/reproduce/reproduce.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/evaluator_option.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/commands/whole_number.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/console/progress.hpp"
#include "coordinator/console/whole_file.hpp"
#include "coordinator/runs/new_folder.hpp"

namespace coppice {
namespace {

struct ReproduceFlags {
  std::string what;
  std::string folder;
  std::optional<std::size_t> workers;
  std::string worker_program;
  ReproduceSettings settings;
  bool json = false;
};

Result<void> write_tables(const std::filesystem::path& folder, const std::vector<Comparison>& tables) {
  std::string text;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Comparison& table : tables) {
    text += to_text(table) + '\n';
    json.push_back(to_json(table));
  }
  if (const auto written = write_whole_file(folder / "tables.txt", text); !written) {
    return written;
  }
  return write_whole_file(folder / "tables.json", json_line(json) + "\n");
}

Result<void> reproduce_command(const ReproduceFlags& options, const StopFlag& stop) {
  if (const Result<void> checked = check_settings(options.settings); !checked) {
    return checked;
  }
  EvaluatorOption evaluator;
  evaluator.workers = options.workers;
  evaluator.serial = !options.workers;
  evaluator.worker_program = options.worker_program;
  const Result<EvaluatorChoice> choice = evaluator_choice(evaluator);
  if (!choice) {
    return tl::unexpected(choice.error());
  }
  if (const Result<void> checked = check_choice(*choice); !checked) {
    return checked;
  }
  const Result<std::filesystem::path> folder = new_folder(options.folder, "coppice-thesis");
  if (!folder) {
    return tl::unexpected(folder.error());
  }
  std::optional<Progress> progress;
  std::vector<Comparison> tables;
  ReproduceHooks hooks;
  hooks.progress = [&](std::uint64_t done, std::uint64_t total, const std::string& doing) {
    if (!progress) {
      progress.emplace(stderr, progress_settings_for(stderr), "reproduce", "steps", total);
    }
    progress->update(done, doing);
  };
  hooks.table = [&](const Comparison& table) {
    tables.push_back(table);
    if (!options.json) {
      fmt::print("{}\n", to_text(table));
      static_cast<void>(std::fflush(stdout));  // what could not be printed is found at the end
    }
  };
  const Result<std::vector<Comparison>> done =
      reproduce_thesis(options.settings, *choice, in_words(*choice), *folder, stop, hooks);
  progress.reset();
  if (!done && tables.empty()) {
    std::error_code ignored;
    std::filesystem::remove(*folder, ignored);  // only if it is empty
    return tl::unexpected(done.error());
  }
  if (const Result<void> written = write_tables(*folder, tables); !written) {
    return written;
  }
  if (!done) {
    return tl::unexpected(Error{done.error().kind, fmt::format("{}; {} of the tables are in {}", done.error().message,
                                                               tables.size(), (*folder / "tables.txt").string())});
  }
  if (options.json) {
    nlohmann::ordered_json json = {{"folder", folder->string()}, {"tables", nlohmann::ordered_json::array()}};
    for (const Comparison& table : tables) {
      json["tables"].push_back(to_json(table));
    }
    fmt::print("{}\n", json_line(json));
    return {};
  }
  fmt::print("tables: {0}/tables.txt, {0}/tables.json; studies: {0}/{1}, {0}/{2}\n", folder->string(), kRoomStudy,
             kGridStudy);
  return {};
}

}  // namespace

void add_reproduce(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<ReproduceFlags>();
  CLI::App* command =
      app.add_subcommand("reproduce", "Run the thesis' experiments again: each table beside the printed one");
  command->add_option("WHAT", options->what, "thesis")->required()->check(CLI::IsMember({"thesis"}));
  command->add_option("-o,--output", options->folder, "The folder to make (default: coppice-thesis-<UTC time>)")
      ->type_name("FOLDER");
  command
      ->add_option("--workers", options->workers, "Start N worker processes on this machine (default: evaluate here)")
      ->type_name("N")
      ->check(whole_number());
  command
      ->add_option("--worker-program", options->worker_program,
                   "What --workers starts (default: coppice-worker beside this program, or on PATH)")
      ->type_name("FILE");
  command->add_option("--seeds", options->settings.seeds, "Evolutions of each experiment: seeds 1 to N")
      ->type_name("N")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--episodes", options->settings.episodes, "Episodes to learn from in the room")
      ->check(whole_number())
      ->capture_default_str();
  add_seed_option(*command, options->settings.learning_seed, "Seed of learning in the room");
  command->add_option("--score-episodes", options->settings.score_episodes, "Episodes in the simulator")
      ->check(whole_number())
      ->capture_default_str();
  add_json_flag(*command, options->json);
  command->footer(
      "Makes uav.coppice and windy.coppice with every run, tables.txt and tables.json; never overwrites.\n"
      "Examples:\n"
      "  coppice reproduce thesis\n"
      "  coppice reproduce thesis -o trial --seeds 3 --workers 2");
  command->callback([&invocation, options] {
    invocation.chosen = [&invocation, options] { return reproduce_command(*options, invocation.stop); };
  });
}

}  // namespace coppice
