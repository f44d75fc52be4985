#include "coordinator/studio/page_data.hpp"

#include <filesystem>
#include <optional>
#include <utility>

#include "common/tree/text.hpp"
#include "common/version.hpp"
#include "coordinator/report/on_chain.hpp"
#include "coordinator/report/score.hpp"
#include "coordinator/studio/page_history.hpp"
#include "coordinator/studio/page_tree.hpp"
#include "coordinator/studio/page_world.hpp"
#include "coordinator/studio/shell_word.hpp"
#include "coordinator/studio/tree_view.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

// The parts of the work, as far as somebody waits for them.
constexpr double kPromiseDone = 0.6;
constexpr double kDisagreementsDone = 0.8;
constexpr double kWorldDone = 0.95;

Json study_json(const Study& study, std::uint32_t steps) {
  const Chain& chain = study.chain();
  return {{"path", study.path()},
          {"name", std::filesystem::path(study.path()).filename().string()},
          {"chain_hash", study.chain_hash().hex()},
          {"states", chain.states()},
          {"transitions", chain.transitions()},
          {"initial_state", chain.initial_state()},
          {"world", !study.problem().simulator.empty() ? "its own simulator"
                    : study.problem().source.empty()   ? study.world().kind
                                                       : "none: imported"},
          {"title", study.problem().title},
          {"source", study.problem().source},
          {"steps", steps}};
}

Json provenance_json(const Study& study, const PageRequest& request, const Json& runs) {
  Json commands = Json::array();
  if (const std::string learn = learn_command(study); !learn.empty()) {
    commands.push_back({{"what", "the policy and its chain"}, {"command", learn}});
  }
  for (const Json& run : runs) {
    commands.push_back({{"what", "run " + run["run"].dump()}, {"command", run["command"]}});
  }
  const std::string tree =
      shell_word(study.path()) + " --tree " + shell_word(to_text(request.tree, study.chain().vocabulary()));
  const std::string simulator = " --episodes " + std::to_string(request.simulate.episodes) + " --steps " +
                                std::to_string(request.simulate.steps) + " --seed " +
                                std::to_string(request.simulate.seed);
  std::string rules;
  for (const std::string& rule : request.rules) {
    rules += " --rule " + shell_word(rule);
  }
  commands.push_back({{"what", "agreement and reward, policy and tree"},
                      {"command", "coppice score " + tree + simulator + " --exact"}});
  commands.push_back({{"what", "figures with intervals, and rules"},
                      {"command", "coppice verify " + tree + simulator + " --resamples " +
                                      std::to_string(request.resamples) + rules}});
  commands.push_back({{"what", "where tree and policy differ, and branches"},
                      {"command", "coppice explain " + tree + " --steps " + std::to_string(request.simulate.steps)}});
  commands.push_back({{"what", "this page"}, {"command", request.command}});
  return {{"version", kVersion},
          {"machine", request.machine},
          {"seed", request.simulate.seed},
          {"episodes", request.simulate.episodes},
          {"resamples", request.resamples},
          {"commands", commands}};
}

}  // namespace

Result<std::optional<World>> simulator_of(const Study& study, const std::string& command) {
  if (const std::string& own = command.empty() ? study.problem().simulator : command; !own.empty()) {
    return std::optional(outside_world(own, study.chain().vocabulary()));
  }
  if (study.world().kind == kNoWorld) {
    return std::optional<World>();
  }
  Result<World> world = make_world(study.world().kind, study.world().room);
  if (!world) {
    return in_context(study.path(), std::move(world).error());
  }
  return std::optional(std::move(*world));
}

Result<Json> page_data(const Study& study, const PageRequest& request, const PageProgress& go_on) {
  const Chain& chain = study.chain();
  const Tree& tree = request.tree;
  const std::uint32_t steps = request.simulate.steps;
  const auto goes_on = [&](double share) { return !go_on || go_on(share); };
  const Result<std::optional<World>> world = simulator_of(study, request.simulator);
  if (!world) {
    return tl::unexpected(world.error());
  }
  if (const Result<void> checked = check_score_settings(request.simulate); !checked) {
    return tl::unexpected(checked.error());
  }
  const World* simulator = *world ? &**world : nullptr;
  const Json tree_part = tree_json(chain, tree, steps);
  const Json policy = policy_json(chain, steps);
  const Result<Promise> promise = promise_of(simulator, study.world().kind, chain, tree,
                                             {.simulate = request.simulate, .resamples = request.resamples},
                                             [&](double share) { return goes_on(kPromiseDone * share); });
  if (!promise) {
    return tl::unexpected(promise.error());
  }
  Json rules = Json::array();
  for (const std::string& rule : request.rules) {
    rules.push_back(rule_json(rule, tree, chain));
  }
  if (!goes_on(kPromiseDone)) {
    return interrupted();
  }
  const Json disagreements = disagreements_json(chain, tree, steps);
  if (!goes_on(kDisagreementsDone)) {
    return interrupted();
  }
  Json room = nullptr;
  if (simulator != nullptr) {
    Result<Json> made =
        world_json(*simulator, chain, tree, request.simulate, [&] { return goes_on(kDisagreementsDone); });
    if (!made) {
      return tl::unexpected(std::move(made).error());
    }
    room = std::move(*made);
  }
  if (!goes_on(kWorldDone)) {
    return interrupted();
  }
  const Result<Json> runs = runs_json(study);
  if (!runs) {
    return tl::unexpected(runs.error());
  }
  Json data = {{"format", "coppice page"}, {"version", kPageDataVersion}, {"study", study_json(study, steps)}};
  data["vocabulary"] = vocabulary_json(chain.vocabulary(), study.problem());
  data["answer"] = {{"from", request.tree_from},
                    {"tree", tree_part},
                    {"policy", policy},
                    {"promise", to_json(*promise)},
                    {"shortfalls", shortfalls_of(*promise, tree_part["figures"], policy, tree_part["view"])},
                    {"rules", rules}};
  data["states"] = states_json(chain, expected_visits(chain, actions_of(chain, tree), steps),
                               expected_visits(chain, actions_of_policy(chain), steps));
  data["disagreements"] = disagreements;
  data["runs"] = *runs;
  data["learning"] = learning_json(study);
  data["world"] = room;
  data["walks"] = room.is_null() ? walks_json(chain, tree, steps, request.simulate.seed) : Json::array();
  data["provenance"] = provenance_json(study, request, *runs);
  return data;
}

}  // namespace coppice
