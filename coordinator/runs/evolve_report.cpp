#include "coordinator/runs/evolve_report.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/tree/text.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

// What workers that answered wrongly have to do with the result.
std::string trust_in_words(const EvolveReport& report) {
  std::string text;
  if (report.rollbacks > 0) {
    text += fmt::format(
        "rolled back {} to generation {}, because a worker had answered wrongly: nothing of what it said is in the "
        "result\n",
        counted(report.rollbacks, "time"), report.begin + 1);
  }
  if (report.suspect_generations() > 0) {
    text += fmt::format(
        "suspect: generations 1 to {} were done before this run was resumed, perhaps with the worker that was "
        "quarantined now; to be sure, begin the run anew with the same settings and seed\n",
        report.suspect_generations());
  }
  return text;
}

// What of the evaluating went another way than to workers; nothing if nothing did.
std::string dispatch_in_words(const DispatchStatistics& statistics) {
  std::string text;
  if (statistics.at_home > 0) {
    text += fmt::format("{} of them evaluated by the coordinator itself: sending them would have taken longer\n",
                        statistics.at_home);
  }
  if (statistics.apart > 0) {
    text += fmt::format("{} of them evaluated in a process of its own, because {} with them\n", statistics.apart,
                        statistics.suspect > 0 ? "workers died" : "too many workers were lost");
  }
  return text;
}

Json dispatch_json(const EvolveReport& report) {
  const DispatchStatistics& statistics = report.dispatch;
  return {{"individuals", statistics.individuals},
          {"repeated", statistics.repeated},
          {"batches", statistics.batches},
          {"duplicates", statistics.duplicates},
          {"compared", statistics.compared},
          {"requeued", statistics.requeued},
          {"retried", statistics.retried},
          {"suspect", statistics.suspect},
          {"apart", statistics.apart},
          {"at_home", statistics.at_home},
          {"copies", statistics.copies},
          {"rejected", statistics.rejected},
          {"workers_lost", statistics.workers_lost},
          {"cross_checked", statistics.cross_checked},
          {"quarantined", statistics.quarantined},
          {"rollbacks", report.rollbacks},
          {"suspect_generations", report.suspect_generations()}};
}

Json estimate_json(const Estimate& estimate) { return {{"mean", estimate.mean}, {"margin", estimate.margin}}; }

Json worth_json(const Worth& worth) {
  return {{"reward", estimate_json(worth.reward)},
          {"agreement", estimate_json(worth.agreement)},
          {"collisions", estimate_json(worth.collisions)}};
}

Json answer_json(const Answer& answer) {
  return {{"prefer", name_of(answer.prefer)},
          {"simulated", answer.simulated},
          {"tried", answer.tried},
          {"episodes", answer.episodes},
          {"tree", worth_json(answer.tree)},
          {"policy", worth_json(answer.policy)},
          {"on_chain", answer.on_chain},
          {"policy_on_chain", answer.policy_on_chain},
          {"good", answer.good},
          {"notes", answer.notes}};
}

// Of what the answer's agreement is a share.
std::string measured_on(const Evolved& evolved, const RolloutConfig& rollout) {
  const bool last_only = rollout.method == Method::rollouts && !evolved.interrupted;
  switch (last_only ? rollout.final_method : rollout.method) {
    case Method::rollouts:
      break;
    case Method::exact:
      return fmt::format("{}, exactly", counted(rollout.steps, "step"));
    case Method::discounted:
      return fmt::format("an endless walk discounted by {}, exactly", rollout.gamma);
    case Method::long_run:
      return "an endless walk, exactly";
  }
  return evolved.interrupted ? "its generation's steps" : fmt::format("{} steps", evolved.final_steps);
}

}  // namespace

Json outcome_json(const EvolveReport& report) {
  const Evolved& evolved = report.evolved;
  return {{"fitness", evolved.best.fitness},         {"agreement", evolved.best.agreement},
          {"final_steps", evolved.final_steps},      {"best_generation", evolved.best.generation},
          {"generations", evolved.generations_done}, {"seconds", report.seconds},
          {"dispatch", dispatch_json(report)}};
}

std::string to_text(const EvolveReport& report, const Study& study) {
  const Evolved& evolved = report.evolved;
  const Vocabulary& vocabulary = study.chain().vocabulary();
  const double individuals = static_cast<double>(std::max<std::uint64_t>(1, report.dispatch.individuals));
  std::string text = fmt::format("run {}: {}, seed {}, {}, {:.1f} s\n", static_cast<std::int64_t>(report.run),
                                 counted(evolved.generations_done, "generation"), report.config.seed,
                                 in_words(report.evaluator), report.seconds);
  text += fmt::format("fitness {:.4f}, agreement {:.1f} % of {}\n", evolved.best.fitness,
                      100.0 * evolved.best.agreement, measured_on(evolved, report.config.rollout));
  text += fmt::format("{} individuals, {:.0f} % of them the same in every state as another of their generation\n",
                      report.dispatch.individuals, 100.0 * static_cast<double>(report.dispatch.repeated) / individuals);
  text += dispatch_in_words(report.dispatch);
  text += trust_in_words(report);
  text += fmt::format("evolved, {}:\n{}\n", counted(report.tree().size(), "node"), to_text(report.tree(), vocabulary));
  text += fmt::format("pruned, {}:\n{}\n", counted(report.pruned.size(), "node"), to_text(report.pruned, vocabulary));
  text += report.answer ? to_text(*report.answer) : std::string();
  if (!evolved.front.members.empty()) {
    text += fmt::format("front: {} (coppice front {})\n", counted(evolved.front.members.size(), "tree"), study.path());
  }
  if (!evolved.pick_fits) {
    text += fmt::format("no tree of the front fits front.pick '{}': this is the one of the highest fitness\n",
                        report.config.front.pick);
  }
  return text;
}

std::string to_json(const EvolveReport& report, const Study& study) {
  const Evolved& evolved = report.evolved;
  const Vocabulary& vocabulary = study.chain().vocabulary();
  Json json = {{"study", study.path()},
               {"run", static_cast<std::int64_t>(report.run)},
               {"status", name_of(report.interrupted() ? RunStatus::interrupted : RunStatus::finished)},
               {"evaluator", in_words(report.evaluator)},
               {"seed", report.config.seed}};
  json.update(outcome_json(report));
  if (!evolved.front.members.empty()) {
    json["front"] = evolved.front.members.size();
    json["pick_fits"] = evolved.pick_fits;
  }
  if (report.answer) {
    json["answer"] = answer_json(*report.answer);
  }
  json["tree"] = to_text(report.tree(), vocabulary);
  json["nodes"] = report.tree().size();
  json["pruned"] = to_text(report.pruned, vocabulary);
  json["pruned_nodes"] = report.pruned.size();
  return json_line(json);
}

}  // namespace coppice
