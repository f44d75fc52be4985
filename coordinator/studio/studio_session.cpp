#include "coordinator/studio/studio_session.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <utility>

#include "common/tree/guard.hpp"
#include "common/tree/simplify.hpp"
#include "common/tree/text.hpp"
#include "coordinator/studio/page_history.hpp"
#include "coordinator/studio/page_tree.hpp"
#include "coordinator/studio/page_trust.hpp"
#include "coordinator/studio/page_world.hpp"
#include "coordinator/studio/tree_export.hpp"
#include "coordinator/trust/rule.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostRules = 50;  // proved in one request

Result<std::string> text_in(const Json& asked, const char* field) {
  if (!asked.is_object() || !asked.contains(field) || !asked[field].is_string()) {
    return bad_input(fmt::format("\"{}\" is missing: expected text", field));
  }
  return asked[field].get<std::string>();
}

Result<std::int64_t> number_in(const Json& asked, const char* field) {
  if (!asked.is_object() || !asked.contains(field) || !asked[field].is_number_integer()) {
    return bad_input(fmt::format("\"{}\" is missing: expected a whole number", field));
  }
  return asked[field].get<std::int64_t>();
}

}  // namespace

Result<std::unique_ptr<StudioSession>> StudioSession::open(Study study, PageRequest request, Breed breed) {
  Result<std::optional<World>> world = simulator_of(study, request.simulator);
  if (!world) {
    return tl::unexpected(std::move(world).error());
  }
  return std::unique_ptr<StudioSession>(
      new StudioSession(std::move(study), std::move(request), std::move(*world), std::move(breed)));
}

StudioSession::StudioSession(Study study, PageRequest request, std::optional<World> world, Breed breed)
    : study_(std::move(study)), request_(std::move(request)), world_(std::move(world)), breed_(std::move(breed)) {
  // The first page is computed while the browser comes up. It reads the study by a connection of its own, so that a
  // large chain keeps nobody waiting for the file.
  const Result<std::int64_t> started = jobs_.start(
      "page", nullptr, [path = study_.path(), request = request_](JobProgress& progress) mutable -> Result<Json> {
        request.simulate.stop = &progress.stop();
        const Result<Study> read = Study::open(path, Study::Access::read);
        if (!read) {
          return tl::unexpected(read.error());
        }
        return page_data(*read, request, [&](double share) {
          progress.show(share, "");
          return !progress.stop().raised();
        });
      });
  page_job_ = started.value_or(0);
}

StudioSession::~StudioSession() = default;

Result<Tree> StudioSession::tree_in(const Json& asked, const char* field) const {
  const Result<std::string> text = text_in(asked, field);
  if (!text) {
    return tl::unexpected(text.error());
  }
  return parse_tree(*text, study_.chain().vocabulary());
}

// {"state", "share", "error", "data"}: data is there once state is "done".
Result<Json> StudioSession::page() {
  const std::optional<Json> job = jobs_.find(page_job_);
  if (!job) {
    return failed("the page's data are gone: start the studio again");
  }
  return Json{{"state", (*job)["state"]},
              {"share", (*job)["share"]},
              {"error", (*job)["error"]},
              {"can_breed", static_cast<bool>(breed_)},
              {"has_simulator", world_.has_value()},
              {"exports", export_formats()},
              {"data", (*job)["result"]}};
}

Result<Json> StudioSession::status() {
  Json kept = Json::array();
  Json rules = Json::array();
  std::int64_t changes = 0;
  {
    const std::lock_guard lock(study_mutex_);
    const Result<std::int64_t> others = study_.changes_by_others();
    if (!others) {
      return tl::unexpected(others.error());
    }
    changes = *others;
    if (changes != others_changes_) {  // the problem lies behind the chain in the file: it is not read for nothing
      others_changes_ = changes;
      if (const Result<void> read = study_.read_problem(); !read) {
        return tl::unexpected(read.error());
      }
    }
    rules = study_.problem().rules;
    const Result<std::vector<KeptTree>> trees = study_.kept_trees();
    if (!trees) {
      return tl::unexpected(trees.error());
    }
    for (const KeptTree& tree : *trees) {
      kept.push_back({{"id", tree.id},
                      {"name", tree.name},
                      {"note", tree.note},
                      {"tree", to_text(tree.tree, study_.chain().vocabulary())},
                      {"kept", tree.kept}});
    }
  }
  return Json{{"changes", fmt::format("{}.{}", changes, own_changes_.load())},
              {"kept", kept},
              {"rules", rules},
              {"jobs", jobs_.list()}};
}

Result<Json> StudioSession::score(const Json& asked) const {
  return tree_in(asked).map([&](const Tree& tree) { return tree_json(study_.chain(), tree, request_.simulate.steps); });
}

Result<Json> StudioSession::rules(const Json& asked) const {
  const Result<Tree> tree = tree_in(asked);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  if (!asked.contains("rules") || !asked["rules"].is_array() || asked["rules"].size() > kMostRules) {
    return bad_input(fmt::format("\"rules\" is missing: expected a list of at most {} texts", kMostRules));
  }
  Json answers = Json::array();
  for (const Json& rule : asked["rules"]) {
    if (!rule.is_string()) {
      return bad_input("\"rules\" holds something that is no text");
    }
    answers.push_back(rule_json(rule.get<std::string>(), *tree, study_.chain()));
  }
  return answers;
}

Result<Json> StudioSession::explain(const Json& asked) const {
  return tree_in(asked).map(
      [&](const Tree& tree) { return disagreements_json(study_.chain(), tree, request_.simulate.steps); });
}

// "states": also what holds only in the chain's states.
Result<Json> StudioSession::prune(const Json& asked) const {
  const Result<Tree> tree = tree_in(asked);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  const Chain& chain = study_.chain();
  const Vocabulary& vocabulary = chain.vocabulary();
  const bool on_states = asked.contains("states") && asked["states"] == true;
  const Simplified simplified = on_states
                                    ? simplify(*tree, vocabulary, StateColumns(vocabulary, chain.parts().features))
                                    : simplify(*tree, vocabulary);
  Json removals = Json::array();
  for (const Removal& removal : simplified.removals) {
    removals.push_back({{"what", removal.what}, {"reason", removal.reason}, {"nodes", removal.nodes}});
  }
  return Json{{"tree", to_text(simplified.tree, vocabulary)}, {"removals", removals}};
}

Result<Json> StudioSession::guard(const Json& asked) const {
  const Result<Tree> tree = tree_in(asked);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  const Vocabulary& vocabulary = study_.chain().vocabulary();
  const Result<Tree> guarded = coppice::guard(*tree, vocabulary);
  if (!guarded) {
    return tl::unexpected(guarded.error());
  }
  return Json{{"tree", to_text(*guarded, vocabulary)}, {"nodes", guarded->size()}};
}

// "features": what is seen in the step that is looked for.
Result<Json> StudioSession::walk(const Json& asked) const {
  const Result<Tree> tree = tree_in(asked);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  const Vocabulary& vocabulary = study_.chain().vocabulary();
  const Json& given = asked.value("features", Json());
  if (!given.is_array() || given.size() != vocabulary.features.size()) {
    return bad_input(fmt::format("\"features\" is missing: expected {} values", vocabulary.features.size()));
  }
  std::vector<std::uint8_t> features;
  for (const Json& value : given) {
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() > UINT8_MAX) {
      return bad_input("\"features\" holds something that is no value");
    }
    features.push_back(value.get<std::uint8_t>());
  }
  if (!world_) {
    return Json(nullptr);
  }
  return replay_to(*world_, study_.chain(), *tree, request_.simulate, features, {});
}

Result<Json> StudioSession::keep(const Json& asked) {
  const Result<Tree> tree = tree_in(asked);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  const Result<std::string> name = text_in(asked, "name");
  if (!name) {
    return tl::unexpected(name.error());
  }
  const Result<std::string> note = text_in(asked, "note");
  if (!note) {
    return tl::unexpected(note.error());
  }
  const std::lock_guard lock(study_mutex_);
  ++own_changes_;
  return study_.keep_tree(*name, *note, *tree).map([](std::int64_t id) { return Json{{"id", id}}; });
}

Result<Json> StudioSession::forget(const Json& asked) {
  const Result<std::int64_t> id = number_in(asked, "id");
  if (!id) {
    return tl::unexpected(id.error());
  }
  const std::lock_guard lock(study_mutex_);
  ++own_changes_;
  return study_.forget_tree(*id).map([] { return Json::object(); });
}

// The rule as it was typed: it has to be one of the vocabulary.
Result<Json> StudioSession::keep_rule(const Json& asked) {
  const Result<std::string> rule = text_in(asked, "rule");
  if (!rule) {
    return tl::unexpected(rule.error());
  }
  if (const Result<Rule> parsed = parse_rule(*rule, study_.chain().vocabulary()); !parsed) {
    return tl::unexpected(parsed.error());
  }
  if (rule->size() > kMaxRule) {
    return bad_input(fmt::format("the rule has {} characters: expected at most {}", rule->size(), kMaxRule));
  }
  const std::lock_guard lock(study_mutex_);
  ++own_changes_;
  return study_
      .change_problem([&](Problem& problem) -> Result<void> {
        if (std::find(problem.rules.begin(), problem.rules.end(), *rule) != problem.rules.end()) {
          return {};
        }
        if (problem.rules.size() == kMaxRules) {
          return bad_input(fmt::format("the study keeps {} rules: expected no more; forget one", kMaxRules));
        }
        problem.rules.push_back(*rule);
        return {};
      })
      .map([] { return Json::object(); });
}

Result<Json> StudioSession::forget_rule(const Json& asked) {
  const Result<std::string> rule = text_in(asked, "rule");
  if (!rule) {
    return tl::unexpected(rule.error());
  }
  const std::lock_guard lock(study_mutex_);
  ++own_changes_;
  return study_
      .change_problem([&](Problem& problem) -> Result<void> {
        std::erase(problem.rules, *rule);
        return {};
      })
      .map([] { return Json::object(); });
}

// The simulator and the chain's intervals for a tree, as a job: {"promise", "shortfalls"}.
Result<Json> StudioSession::simulate(const Json& asked) {
  const Result<Tree> tree = tree_in(asked);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  const Chain& chain = study_.chain();
  const Json about = {{"tree", to_text(*tree, chain.vocabulary())}};
  const auto work = [this, &chain, tree = *tree](JobProgress& progress) -> Result<Json> {
    PromiseSettings settings{.simulate = request_.simulate, .resamples = request_.resamples};
    settings.simulate.stop = &progress.stop();
    const Result<Promise> promise =
        promise_of(world_ ? &*world_ : nullptr, study_.world().kind, chain, tree, settings, [&](double share) {
          progress.show(share, "");
          return !progress.stop().raised();
        });
    if (!promise) {
      return tl::unexpected(promise.error());
    }
    const Json part = tree_json(chain, tree, settings.simulate.steps);
    return Json{{"promise", to_json(*promise)},
                {"shortfalls",
                 shortfalls_of(*promise, part["figures"], policy_json(chain, settings.simulate.steps), part["view"])}};
  };
  return jobs_.start("simulate", about, work).map([](std::int64_t id) { return Json{{"job", id}}; });
}

Result<Json> StudioSession::breed(const Json& asked) {
  if (!breed_) {
    return failed("this studio cannot breed");
  }
  const Result<Tree> tree = tree_in(asked);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  const Json settings = asked.value("settings", Json::object());
  const Json about = {{"tree", to_text(*tree, study_.chain().vocabulary())}, {"settings", settings}};
  return jobs_
      .start("breed", about,
             [this, tree = *tree, settings](JobProgress& progress) { return breed_(tree, settings, progress); })
      .map([](std::int64_t id) {
        return Json{{"job", id}};
      });
}

Result<Json> StudioSession::job(const Json& asked) const {
  const Result<std::int64_t> id = number_in(asked, "job");
  if (!id) {
    return tl::unexpected(id.error());
  }
  const std::optional<Json> found = jobs_.find(*id);
  if (!found) {
    return bad_input(fmt::format("there is no computation of number {}", *id));
  }
  return *found;
}

Result<Json> StudioSession::stop(const Json& asked) {
  return number_in(asked, "job").map([&](std::int64_t id) { return Json{{"stopped", jobs_.stop(id)}}; });
}

// A tree in a format of others: {"name", "type", "text"}.
Result<Json> StudioSession::write(const Json& asked) const {
  const Result<Tree> tree = tree_in(asked);
  if (!tree) {
    return tl::unexpected(tree.error());
  }
  const Result<std::string> format = text_in(asked, "format");
  if (!format) {
    return tl::unexpected(format.error());
  }
  const std::lock_guard lock(study_mutex_);
  return export_tree(*tree, study_, *format);
}

std::optional<Result<Json>> StudioSession::answer(const std::string& name, const Json& asked) {
  if (name == "page") {
    return page();
  }
  if (name == "status") {
    return status();
  }
  if (name == "runs") {
    const std::lock_guard lock(study_mutex_);
    return runs_json(study_);
  }
  using Call = std::function<Result<Json>(const Json&)>;
  const std::array<std::pair<const char*, Call>, 15> calls{{
      {"score", [this](const Json& a) { return score(a); }},
      {"rules", [this](const Json& a) { return rules(a); }},
      {"explain", [this](const Json& a) { return explain(a); }},
      {"prune", [this](const Json& a) { return prune(a); }},
      {"guard", [this](const Json& a) { return guard(a); }},
      {"walk", [this](const Json& a) { return walk(a); }},
      {"keep", [this](const Json& a) { return keep(a); }},
      {"forget", [this](const Json& a) { return forget(a); }},
      {"keep_rule", [this](const Json& a) { return keep_rule(a); }},
      {"forget_rule", [this](const Json& a) { return forget_rule(a); }},
      {"simulate", [this](const Json& a) { return simulate(a); }},
      {"breed", [this](const Json& a) { return breed(a); }},
      {"job", [this](const Json& a) { return job(a); }},
      {"stop", [this](const Json& a) { return stop(a); }},
      {"write", [this](const Json& a) { return write(a); }},
  }};
  for (const auto& [known, call] : calls) {
    if (name == known) {
      return call(asked);
    }
  }
  return std::nullopt;
}

}  // namespace coppice
