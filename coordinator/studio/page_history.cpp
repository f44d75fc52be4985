#include "coordinator/studio/page_history.hpp"

#include <array>
#include <fmt/format.h>
#include <vector>

#include "common/tree/text.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/studio/page_numbers.hpp"
#include "coordinator/studio/shell_word.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

Json parsed(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? Json(nullptr) : json;
}

Json generations_json(const std::vector<GenerationRecord>& generations) {
  const std::size_t every = (generations.size() + kMostPageGenerations - 1) / kMostPageGenerations;
  Json columns = {{"every", every},
                  {"total", generations.size()},
                  {"generation", Json::array()},
                  {"best_fitness", Json::array()},
                  {"mean_fitness", Json::array()},
                  {"best_agreement", Json::array()},
                  {"mean_agreement", Json::array()},
                  {"best_nodes", Json::array()},
                  {"mean_nodes", Json::array()},
                  {"distinct_trees", Json::array()},
                  {"evaluations", Json::array()}};
  std::uint64_t evaluations = 0;
  for (std::size_t i = 0; i < generations.size(); ++i) {
    const GenerationRecord& record = generations[i];
    evaluations += record.evaluations;
    if (i % every != 0 && i + 1 != generations.size()) {
      continue;
    }
    columns["generation"].push_back(record.generation);
    columns["best_fitness"].push_back(page_number(record.best.fitness));
    columns["mean_fitness"].push_back(page_number(record.mean_fitness));
    columns["best_agreement"].push_back(page_number(record.best.agreement));
    columns["mean_agreement"].push_back(page_number(record.mean_agreement));
    columns["best_nodes"].push_back(record.best_nodes());
    columns["mean_nodes"].push_back(page_number(record.mean_nodes));
    columns["distinct_trees"].push_back(record.distinct_trees);
    columns["evaluations"].push_back(evaluations);
  }
  return columns;
}

// How each of a run's demes went, sampled; null: it had one, or did not keep that.
Json demes_json(const DemeGenerations& kept) {
  if (kept.demes.empty()) {
    return nullptr;
  }
  const std::size_t total = kept.generation.size();
  const std::size_t every = (total + kMostPageDemeGenerations - 1) / kMostPageDemeGenerations;
  Json json = {{"every", every}, {"total", total}, {"generation", Json::array()}, {"demes", Json::array()}};
  for (std::size_t i = 0; i < total; ++i) {
    if (i % every == 0 || i + 1 == total) {
      json["generation"].push_back(kept.generation[i]);
    }
  }
  for (const std::vector<DemeGeneration>& deme : kept.demes) {
    Json columns = {{"best_fitness", Json::array()},
                    {"mean_fitness", Json::array()},
                    {"best_nodes", Json::array()},
                    {"mean_nodes", Json::array()},
                    {"evaluations", Json::array()}};
    std::uint64_t evaluations = 0;
    for (std::size_t i = 0; i < total; ++i) {
      evaluations += deme[i].evaluations;
      if (i % every == 0 || i + 1 == total) {
        columns["best_fitness"].push_back(page_number(deme[i].best_fitness));
        columns["mean_fitness"].push_back(page_number(deme[i].mean_fitness));
        columns["best_nodes"].push_back(deme[i].best_nodes);
        columns["mean_nodes"].push_back(page_number(deme[i].mean_nodes));
        columns["evaluations"].push_back(evaluations);
      }
    }
    json["demes"].push_back(std::move(columns));
  }
  return json;
}

Json front_json(const Front& front, const Vocabulary& vocabulary) {
  if (front.members.empty()) {
    return nullptr;
  }
  Json measures = Json::array();
  for (const Measure measure : front.measures) {
    measures.push_back({{"name", name_of(measure)}, {"is_cost", is_cost(measure)}});
  }
  Json members = Json::array();
  for (const FrontMember& member : front.members) {
    Json values = Json::array();
    for (const double value : member.values) {
      values.push_back(page_number(value));
    }
    members.push_back(
        {{"tree", to_text(member.tree, vocabulary)}, {"fitness", page_number(member.fitness)}, {"values", values}});
  }
  return {{"measures", measures}, {"members", members}};
}

// Every key of a run's configuration that is not at its default, as --set takes it. Rules of the shaped objective have
// no such form; they are in "configuration".
std::string assignments(const EvolveConfig& config) {
  const Json defaults = Json::parse(config_to_json(EvolveConfig{})).flatten();
  const Json sections = Json::parse(config_to_json(config));
  std::string text;
  for (const auto& [section, object] : sections.items()) {
    if (!object.is_object()) {
      continue;  // the seed has a flag of its own
    }
    for (const auto& [key, value] : object.items()) {
      const std::string pointer = fmt::format("/{}/{}", section, key);
      if (!value.is_array() && (!defaults.contains(pointer) || defaults[pointer] != value)) {
        const std::string shown = value.is_string() ? value.get<std::string>() : value.dump();
        text += " --set " + shell_word(fmt::format("{}.{}={}", section, key, shown));
      }
    }
  }
  return text;
}

}  // namespace

std::string evolve_command(const Study& study, const RunRecord& run) {
  return fmt::format("coppice evolve {} --config thesis --seed {}{}", shell_word(study.path()), run.config.seed,
                     assignments(run.config));
}

Json learning_json(const Study& study) {
  return {{"settings", parsed(study.learning().settings)}, {"outcome", parsed(study.learning().outcome)}};
}

std::string learn_command(const Study& study) {
  const Json settings = parsed(study.learning().settings);
  if (!settings.is_object() || !settings.contains("world") || !settings.contains("episodes")) {
    return "";
  }
  std::string text = "coppice learn -o " + shell_word(study.path());
  for (const auto& [key, flag] : std::array<std::pair<const char*, const char*>, 9>{{{"world", "--world"},
                                                                                     {"algorithm", "--algorithm"},
                                                                                     {"episodes", "--episodes"},
                                                                                     {"steps", "--steps"},
                                                                                     {"alpha", "--alpha"},
                                                                                     {"gamma", "--gamma"},
                                                                                     {"epsilon", "--epsilon"},
                                                                                     {"decay", "--decay"},
                                                                                     {"seed", "--seed"}}}) {
    if (settings.contains(key)) {
      const Json& value = settings[key];
      text += fmt::format(" {} {}", flag, shell_word(value.is_string() ? value.get<std::string>() : value.dump()));
    }
  }
  return text;
}

Result<Json> runs_json(const Study& study) {
  const Result<std::vector<RunRecord>> runs = study.runs();
  if (!runs) {
    return tl::unexpected(runs.error());
  }
  const Vocabulary& vocabulary = study.chain().vocabulary();
  Json list = Json::array();
  for (const RunRecord& run : *runs) {
    const Result<std::vector<GenerationRecord>> generations = study.generations(run.id);
    if (!generations) {
      return tl::unexpected(generations.error());
    }
    const Result<Front> front = study.front(run.id);
    if (!front) {
      return tl::unexpected(front.error());
    }
    const Result<DemeGenerations> demes = study.deme_generations(run.id);
    if (!demes) {
      return tl::unexpected(demes.error());
    }
    Json result = parsed(run.json);
    if (result.is_object()) {
      result.erase("deme_curves");  // as earlier versions kept them, of runs that had ended
    }
    list.push_back({{"run", static_cast<std::int64_t>(run.id)},
                    {"status", name_of(run.status)},
                    {"abandoned", run.abandoned},
                    {"evaluator", run.evaluator},
                    {"started", run.started},
                    {"ended", run.ended},
                    {"seed", run.config.seed},
                    {"configuration", parsed(config_to_json(run.config))},
                    {"result", result},
                    {"demes", demes_json(*demes)},
                    {"tree", run.tree ? Json(to_text(*run.tree, vocabulary)) : Json(nullptr)},
                    {"pruned", run.pruned ? Json(to_text(*run.pruned, vocabulary)) : Json(nullptr)},
                    {"command", evolve_command(study, run)},
                    {"generations", generations_json(*generations)},
                    {"front", front_json(*front, vocabulary)}});
  }
  return list;
}

}  // namespace coppice
