#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/tree/text.hpp"
#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/console/printable.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/problem/legend.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kAheadFeature = "s3";  // the sensor ahead, thesis Figure 7
constexpr std::uint8_t kWall = 0;

struct InfoFlags {
  std::string study;
  std::optional<std::int64_t> run;  // empty: all
  bool json = false;
};

std::size_t rows_never_tried(const Chain& chain) {
  std::size_t rows = 0;
  for (std::size_t row = 0; row < chain.states() * chain.actions(); ++row) {
    rows += chain.tries(row) == 0 && !chain.is_forbidden(row / chain.actions(), row % chain.actions()) ? 1U : 0U;
  }
  return rows;
}

std::optional<std::size_t> states_with_wall_ahead(const Chain& chain) {
  const std::optional<std::size_t> ahead = chain.vocabulary().find_feature(kAheadFeature);
  if (!ahead) {
    return std::nullopt;
  }
  std::size_t states = 0;
  for (std::size_t state = 0; state < chain.states(); ++state) {
    states += chain.features_of(state)[*ahead] == kWall ? 1U : 0U;
  }
  return states;
}

std::string features_text(const Chain& chain, std::size_t state) {
  std::string text;
  for (std::size_t i = 0; i < chain.vocabulary().features.size(); ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : " ",
                        chain.vocabulary().features[i].reading_text(chain.features_of(state)[i]));
  }
  return text;
}

std::string no_action_text(const Chain& chain) {
  const NoAction& rule = chain.parts().no_action;
  switch (rule.kind) {
    case NoAction::Kind::hold:
      return "hold";
    case NoAction::Kind::worst:
      return "worst";
    case NoAction::Kind::named:
      break;
  }
  return chain.vocabulary().actions[index_of(rule.action)];
}

// What a simulator is made of.
std::string world_text(const Study& study) {
  if (!study.problem().simulator.empty()) {
    return "its own simulator";
  }
  return study.problem().source.empty() ? study.world().kind : "imported";
}

// What a problem has that our own worlds have not.
void add_problem(const Study& study, Json& json) {
  const Chain& chain = study.chain();
  const ChainParts& parts = chain.parts();
  const Problem& problem = study.problem();
  for (const auto& [key, text] : {std::pair{"title", &problem.title}, std::pair{"source", &problem.source},
                                  std::pair{"simulator", &problem.simulator}}) {
    if (!text->empty()) {
      json[key] = *text;
    }
  }
  if (!problem.rules.empty()) {
    json["rules"] = problem.rules;
  }
  if (problem.discount) {
    json["discount"] = *problem.discount;
  }
  if (chain.starts().size() > 1) {
    json["starts"] = chain.starts().size();
  }
  if (!parts.terminals.empty()) {
    json["terminal_states"] = parts.terminals.size();
  }
  if (!parts.forbidden.empty()) {
    json["rows_forbidden"] = std::count(parts.forbidden.begin(), parts.forbidden.end(), 1);
  }
  json["no_action"] = no_action_text(chain);
}

// The study keeps JSON as it was given; a damaged one is shown as the text that it is.
Json parsed(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? Json(text) : json;
}

Json json_of(const std::vector<GenerationRecord>& generations) {
  Json json = Json::array();
  for (const GenerationRecord& record : generations) {
    json.push_back({{"generation", record.generation},
                    {"best_fitness", record.best.fitness},
                    {"mean_fitness", record.mean_fitness},
                    {"best_nodes", record.best_nodes()},
                    {"mean_nodes", record.mean_nodes},
                    {"best_agreement", record.best.agreement},
                    {"mean_agreement", record.mean_agreement}});
  }
  return json;
}

// What a run's configuration changes of the thesis': "ga.population=200 fitness.coverage=0.5".
std::string changes_text(const Json& configuration) {
  const Json defaults = parsed(config_to_json(EvolveConfig{})).flatten();
  std::string text;
  const auto append = [&text](const std::string& key, const Json& value) {
    text += fmt::format("{}{}={}", text.empty() ? "" : " ", key,
                        value.is_string() ? value.get<std::string>() : json_line(value));
  };
  for (const auto& [section, object] : configuration.items()) {
    if (!object.is_object()) {
      if (section != "seed") {  // has a place of its own
        append(section, object);
      }
      continue;
    }
    for (const auto& [key, value] : object.items()) {
      const std::string pointer = fmt::format("/{}/{}", section, key);
      const bool no_rules = value.is_array() && value.empty();  // flatten() makes null of it
      const bool is_default = no_rules || (defaults.contains(pointer) && defaults[pointer] == value);
      if (!is_default) {
        append(fmt::format("{}.{}", section, key), value);
      }
    }
  }
  return text.empty() ? "as in the thesis" : text + ", else as in the thesis";
}

Json json_of(const RunRecord& run, const Vocabulary& vocabulary) {
  Json json = {{"run", static_cast<std::int64_t>(run.id)},
               {"status", name_of(run.status)},
               {"resumable", run.abandoned || (run.status != RunStatus::finished && run.status != RunStatus::running)},
               {"evaluator", run.evaluator},
               {"started", run.started},
               {"ended", run.ended},
               {"seed", run.config.seed},
               {"generations", run.generations},
               {"configuration", parsed(config_to_json(run.config))},
               {"result", parsed(run.json)}};
  if (run.tree) {
    json["tree"] = to_text(*run.tree, vocabulary);
    json["nodes"] = run.tree->size();
  }
  if (run.pruned) {
    json["pruned"] = to_text(*run.pruned, vocabulary);
    json["pruned_nodes"] = run.pruned->size();
  }
  return json;
}

Result<Json> json_of(const Study& study, const std::vector<RunRecord>& runs) {
  const Chain& chain = study.chain();
  Json json = {{"study", study.path()},
               {"chain", study.chain_hash().hex()},
               {"world", world_text(study)},
               {"states", chain.states()},
               {"actions", chain.vocabulary().actions},
               {"transitions", chain.transitions()},
               {"rows", chain.states() * chain.actions()},
               {"rows_never_tried", rows_never_tried(chain)}};
  if (const auto walls = states_with_wall_ahead(chain)) {
    json["states_with_wall_ahead"] = *walls;
  }
  json["initial_state"] = {{"index", chain.initial_state()}, {"features", features_text(chain, chain.initial_state())}};
  add_problem(study, json);
  for (std::size_t f = 0; f < chain.vocabulary().features.size(); ++f) {
    if (const std::string line = feature_legend(f, study.problem(), chain.vocabulary()); !line.empty()) {
      json["legend"].push_back(line);
    }
  }
  for (std::size_t a = 0; a < chain.actions(); ++a) {
    if (const std::string line = action_legend(a, study.problem(), chain.vocabulary()); !line.empty()) {
      json["legend"].push_back(line);
    }
  }
  json["learning"] = {{"settings", parsed(study.learning().settings)}, {"outcome", parsed(study.learning().outcome)}};
  json["runs"] = Json::array();
  for (const RunRecord& run : runs) {
    const Result<std::vector<GenerationRecord>> generations = study.generations(run.id);
    if (!generations) {
      return tl::unexpected(generations.error());
    }
    json["runs"].push_back(json_of(run, chain.vocabulary()));
    json["runs"].back()["statistics"] = json_of(*generations);
  }
  return json;
}

std::string pairs_text(const Json& object) {
  if (!object.is_object()) {
    return json_line(object);
  }
  std::string text;
  for (const auto& [key, value] : object.items()) {
    const std::string shown = value.is_string() ? value.get<std::string>() : json_line(value);
    text += fmt::format("{}{}={}", text.empty() ? "" : " ", key, shown);
  }
  return text;
}

void print_line(std::string_view name, const std::string& value) { fmt::print("{:<22} {}\n", name, printable(value)); }

void print_text(const Json& json) {
  for (const auto& [key, name] :
       std::vector<std::pair<const char*, const char*>>{{"study", "study"},
                                                        {"chain", "chain"},
                                                        {"world", "world"},
                                                        {"states", "states"},
                                                        {"transitions", "transitions"},
                                                        {"rows", "rows (state, action)"},
                                                        {"rows_never_tried", "rows never tried"},
                                                        {"states_with_wall_ahead", "wall ahead, states"},
                                                        {"title", "title"},
                                                        {"source", "imported from"},
                                                        {"simulator", "simulator"},
                                                        {"discount", "discount"},
                                                        {"starts", "episodes start in, states"},
                                                        {"terminal_states", "terminal states"},
                                                        {"rows_forbidden", "rows that lack the action"},
                                                        {"no_action", "no action means"}}) {
    if (json.contains(key)) {
      print_line(name, json[key].is_string() ? json[key].get<std::string>() : json[key].dump());
    }
  }
  print_line("actions", pairs_text(json["actions"]));
  if (json.contains("legend")) {
    for (std::size_t i = 0; i < json["legend"].size(); ++i) {
      print_line(i == 0 ? "legend" : "", json["legend"][i].get<std::string>());
    }
  }
  if (json.contains("rules")) {
    for (std::size_t i = 0; i < json["rules"].size(); ++i) {
      print_line(i == 0 ? "rules kept" : "", json["rules"][i].get<std::string>());
    }
  }
  print_line("initial state", fmt::format("{}: {}", json["initial_state"]["index"].dump(),
                                          json["initial_state"]["features"].get<std::string>()));
  print_line("learned with", pairs_text(json["learning"]["settings"]));
  Json learned = json["learning"]["outcome"];
  if (learned.is_object()) {
    learned.erase("curve");  // hundreds of numbers: for --json and 'coppice report'
  }
  print_line("learned", pairs_text(learned));
  if (json["runs"].empty()) {
    print_line("runs", "none");
  }
  for (const Json& run : json["runs"]) {
    fmt::print("\n");
    print_line(
        fmt::format("run {}", run["run"].dump()),
        fmt::format("{}{}, {}, seed {}, {}, started {}{}", run["status"].get<std::string>(),
                    run["resumable"].get<bool>() ? " (evolve --resume goes on)" : "",
                    run["evaluator"].get<std::string>(), run["seed"].dump(),
                    counted(run["generations"].get<std::uint64_t>(), "generation"), run["started"].get<std::string>(),
                    run["ended"].get<std::string>().empty() ? "" : ", ended " + run["ended"].get<std::string>()));
    print_line("  configuration", changes_text(run["configuration"]));
    Json result = run["result"];
    if (result.is_object()) {
      result.erase("deme_curves");  // written by earlier versions, for the page
    }
    print_line("  result", pairs_text(result));
    for (const char* tree : {"tree", "pruned"}) {
      if (run.contains(tree)) {
        const std::string nodes = std::string(tree) == "tree" ? "nodes" : "pruned_nodes";
        print_line(fmt::format("  {}, {}", tree, counted(run[nodes].get<std::uint64_t>(), "node")),
                   run[tree].get<std::string>());
      }
    }
  }
}

Result<void> info_command(const InfoFlags& options) {
  const Result<Study> study = Study::open(options.study, Study::Access::read);
  if (!study) {
    return tl::unexpected(study.error());
  }
  Result<std::vector<RunRecord>> runs = study->runs();
  if (runs && options.run) {
    runs = study->run(RunId{*options.run}).map([](RunRecord&& run) { return std::vector<RunRecord>{std::move(run)}; });
  }
  if (!runs) {
    return in_context(options.study, std::move(runs).error());
  }
  const Result<Json> json = json_of(*study, *runs);
  if (!json) {
    return tl::unexpected(json.error());
  }
  if (options.json) {
    fmt::print("{}\n", json_line(*json));
  } else {
    print_text(*json);
  }
  return {};
}

}  // namespace

void add_info(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<InfoFlags>();
  CLI::App* command = app.add_subcommand("info", "Say what a study holds: the chain, how it was learned, its runs");
  add_study_argument(*command, options->study);
  add_run_option(*command, options->run, "Only this run (default: all)");
  add_json_flag(*command, options->json);
  command->footer(
      "Examples:\n"
      "  coppice info uav.coppice\n"
      "  coppice info uav.coppice --run 2");
  command->callback([&invocation, options] { invocation.chosen = [options] { return info_command(*options); }; });
}

}  // namespace coppice
