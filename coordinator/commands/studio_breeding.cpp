#include "coordinator/commands/studio_breeding.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>
#include <vector>

#include "common/tree/guard.hpp"
#include "common/tree/simplify.hpp"
#include "common/tree/text.hpp"
#include "common/tree/tree_size.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/runs/evolve_in_study.hpp"
#include "coordinator/studio/page_numbers.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

std::size_t most_children(const Tree& tree) {
  std::size_t most = 0;
  for (std::size_t node = 0; node < tree.size(); ++node) {
    most = std::max(most, child_count(tree.subtree(node)));
  }
  return most;
}

// A founder that a hand has shaped may be larger than what the last run was allowed to breed.
void make_room_for(const Tree& founder, EvolveConfig& config) {
  const auto at_least = [](std::uint32_t& limit, std::size_t size) {
    limit = std::max(limit, static_cast<std::uint32_t>(size));
  };
  at_least(config.ga.max_depth, founder.depth());
  at_least(config.ga.max_children, most_children(founder));
  at_least(config.ga.max_nodes, founder.size());
  at_least(config.ga.max_conditions, condition_count(founder.nodes()));
  at_least(config.front.max_nodes, founder.size());
}

// The configuration of the study's last run, so that what is bred can be compared with it; of a study without a run,
// the defaults. Then what was asked for, then the founder, in front of any other.
Result<EvolveConfig> config_of(const Study& study, const Tree& given, const Json& settings) {
  const Result<std::optional<RunRecord>> last = study.last_run();
  if (!last) {
    return tl::unexpected(last.error());
  }
  EvolveConfig config = *last ? (*last)->config : EvolveConfig{};
  if (settings.is_object() && settings.contains("set")) {
    if (!settings["set"].is_array()) {
      return bad_input("\"set\" is no list: expected texts such as ga.generations=200");
    }
    for (const Json& setting : settings["set"]) {
      if (!setting.is_string()) {
        return bad_input("\"set\" holds something that is no text: expected such as ga.generations=200");
      }
      if (const Result<void> applied = apply_setting(setting.get<std::string>(), config); !applied) {
        return tl::unexpected(applied.error());
      }
    }
  }
  // Composites of one child, which a hand may leave, are nothing that evolution breeds; nor, where it breeds guarded
  // trees only, is one that acts before it asks.
  const Vocabulary& vocabulary = study.chain().vocabulary();
  const Result<Tree> founder =
      config.ga.form == Form::guarded ? guard(given, vocabulary) : Result<Tree>(simplify(given, vocabulary).tree);
  if (!founder) {
    return tl::unexpected(founder.error());
  }
  make_room_for(*founder, config);
  const std::string text = to_text(*founder, vocabulary);
  config.ga.founders = config.ga.founders.empty() ? text : text + ";" + config.ga.founders;
  if (const Result<void> checked = check_config(config, vocabulary); !checked) {
    return tl::unexpected(checked.error());
  }
  return config;
}

// What they have done together, then each.
Json workers_json(const DispatchStatistics& statistics, const EvaluatorChoice& choice,
                  const std::vector<ListedWorker>& workers) {
  Json json = Json::array({{{"name", in_words(choice)},
                            {"doing", fmt::format("{} individuals evaluated, {} lost", statistics.individuals,
                                                  counted(statistics.workers_lost, "worker"))}}});
  for (const ListedWorker& worker : workers) {
    json.push_back({{"name", fmt::format("{}, pid {}", worker.host, worker.pid)},
                    {"doing", fmt::format("{}; {} individuals a second, {} since its start", worker.doing,
                                          worker.each_second, worker.evaluated)}});
  }
  return json;
}

Result<Json> breed(const std::string& path, const EvaluatorChoice& evaluator, const Tree& founder, const Json& settings,
                   JobProgress& progress) {
  Result<Study> study = Study::open(path);  // a connection of its own: the studio goes on reading
  if (!study) {
    return tl::unexpected(std::move(study).error());
  }
  const Result<EvolveConfig> config = config_of(*study, founder, settings);
  if (!config) {
    return tl::unexpected(config.error());
  }
  const Vocabulary& vocabulary = study->chain().vocabulary();
  std::uint32_t generations = config->ga.generations;
  // All on this thread, which dispatches: as of the last generation, and of the last look at the workers.
  Json detail = Json::object();
  DispatchStatistics statistics;
  std::vector<ListedWorker> workers;
  const auto show = [&] {
    detail["workers"] = workers_json(statistics, evaluator, workers);
    progress.detail(detail);
  };
  EvaluatorChoice watched = evaluator;
  watched.watch_workers = [&](const std::vector<ListedWorker>& now) {
    workers = now;
    show();
  };
  EvolveWatch watch;
  watch.started = [&](RunId /*run*/, std::uint32_t total, std::uint32_t /*begin*/) { generations = total; };
  watch.generation_done = [&](const GenerationRecord& record, const DispatchStatistics& so_far) {
    progress.show((record.generation + 1.0) / std::max<std::uint32_t>(generations, 1), "");
    detail = {{"generation", record.generation + 1},
              {"generations", generations},
              {"best_fitness", page_number(record.best.fitness)},
              {"mean_fitness", page_number(record.mean_fitness)},
              {"best_nodes", record.best_nodes()},
              {"best_tree", to_text(record.best.tree, vocabulary)}};
    statistics = so_far;
    show();
  };
  const Result<EvolveReport> evolved = evolve_in_study(
      *study, {.config = *config, .resumed = std::nullopt, .evaluator = watched}, progress.stop(), watch);
  if (!evolved) {
    return tl::unexpected(evolved.error());
  }
  progress.detail({{"generation", evolved->evolved.generations_done},
                   {"generations", generations},
                   {"best_fitness", page_number(evolved->evolved.best.fitness)},
                   {"best_nodes", evolved->pruned.size()},
                   {"best_tree", to_text(evolved->pruned, vocabulary)},
                   {"workers", workers_json(evolved->dispatch, evaluator, {})}});
  progress.show(1.0, fmt::format("run {}", static_cast<std::int64_t>(evolved->run)));
  return Json{{"run", static_cast<std::int64_t>(evolved->run)}, {"tree", to_text(evolved->pruned, vocabulary)}};
}

}  // namespace

Breed breeding_in(const std::string& study_path, EvaluatorChoice evaluator) {
  return
      [study_path, evaluator = std::move(evaluator)](const Tree& founder, const Json& settings, JobProgress& progress) {
        return breed(study_path, evaluator, founder, settings, progress);
      };
}

}  // namespace coppice
