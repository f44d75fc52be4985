#include "coordinator/trust/explanation_report.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "common/tree/text.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/trust/jumps.hpp"
#include "coordinator/trust/verification_report.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

std::string action_text(const Vocabulary& vocabulary, ActionId action) {
  return action == kNoAction ? "none" : vocabulary.actions[index_of(action)];
}

std::string condition_text(const Group& group, const Vocabulary& vocabulary) {
  std::string text;
  for (const Node& test : group.tests) {
    text += (text.empty() ? "" : " and ") + to_text(test, vocabulary);
  }
  return text;
}

double share(double part, double whole) { return whole > 0.0 ? 100.0 * part / whole : 0.0; }

std::string visits_text(Weighting weighting) {
  switch (weighting) {
    case Weighting::tree:
      return "expected visits in an episode of the tree on the chain";
    case Weighting::policy:
      return "expected visits in an episode of the policy on the chain";
    case Weighting::learning:
      return "visits in an episode of learning";
    case Weighting::states:
      break;
  }
  return "1 for every state";
}

Json json_of(const TreeFigures& figures) {
  return {{"nodes", figures.nodes},
          {"agreement_over_states", figures.coverage()},
          {"agreement_along_chain", figures.along_chain.agreement},
          {"reward_along_chain", figures.along_chain.reward}};
}

}  // namespace

ExplainReport explain_report(const Chain& chain, const Tree& tree, const ExplainSettings& settings) {
  ExplainReport report{
      .explanation = explain(chain, tree, settings), .now = figures_of(chain, tree, settings.steps), .suggestions = {}};
  const Vocabulary& vocabulary = chain.vocabulary();
  Tree together = tree;
  for (const Group& group : report.explanation.groups) {
    const Tree branch = branch_of(group);
    // A later group changes what the earlier ones made of its states: its branch is tried first.
    together = with_branch(together, branch);
    const std::string text = to_text(branch, vocabulary);
    report.suggestions.push_back(
        {.branch = branch,
         .edit = tree[0].kind == NodeKind::selector
                     ? fmt::format("--insert '0 0 {}'", text)
                     : fmt::format("--replace '0 (selector {} {})'", text, to_text(tree, vocabulary)),
         .alone = figures_of(chain, with_branch(tree, branch), settings.steps),
         .together = figures_of(chain, together, settings.steps),
         .together_tree = together});
  }
  return report;
}

std::string to_text(const ExplainReport& report, const Chain& chain, const Tree& tree, const Problem& problem,
                    std::size_t most_states) {
  const Explanation& explanation = report.explanation;
  const Vocabulary& vocabulary = chain.vocabulary();
  std::string text = numbered(tree, vocabulary, problem);
  text += fmt::format(
      "\ntree and policy differ in {} of {}; together that costs {:.2f} an episode of {}\n"
      "cost = visits x regret; visits: {}; regret = V(s) - Q(s, tree's action)\n",
      explanation.disagreements.size(), counted(explanation.states, "state"), explanation.cost,
      counted(explanation.settings.steps, "step"), visits_text(explanation.settings.weighting));
  const std::size_t shown = std::min(most_states, explanation.disagreements.size());
  if (shown > 0) {
    text += fmt::format("\n  {:>8} {:>6} {:>9} {:>8}  {:<12}{:<12}{:<6}{}\n", "cost", "share", "visits", "regret",
                        "policy", "tree", "node", "where");
  }
  for (std::size_t i = 0; i < shown; ++i) {
    const Disagreement& d = explanation.disagreements[i];
    text += fmt::format("  {:>8.3f} {:>5.1f}% {:>9.4f} {:>8.3f}  {:<12}{:<12}{:<6}{}\n", d.cost(),
                        share(d.cost(), explanation.cost), d.visits, d.regret, action_text(vocabulary, d.policy),
                        action_text(vocabulary, d.tree), d.writer == kTickEnds ? "-" : std::to_string(d.writer),
                        observation_text(vocabulary, chain.features_of(d.state)));
  }
  if (shown < explanation.disagreements.size()) {
    text += fmt::format("  and {} more\n", explanation.disagreements.size() - shown);
  }
  if (explanation.groups.empty()) {
    return text + "\nno branch of so few tests saves anything worth it\n";
  }
  text += fmt::format("\nbranches that would mend most of it, each added in front of those before it ({} at most{}):\n",
                      counted(explanation.settings.tests, "test"),
                      explanation.complete ? ", the best there is" : ", the best found in the time allowed");
  for (std::size_t i = 0; i < explanation.groups.size(); ++i) {
    const Group& group = explanation.groups[i];
    const Suggestion& suggestion = report.suggestions[i];
    text += fmt::format("\n{}. when {}: {}\n", i + 1, condition_text(group, vocabulary),
                        action_text(vocabulary, group.action));
    text += fmt::format("   saves {:.2f}, {:.1f} % of the cost: {} of {} now differ, it mends {} and spoils {}\n",
                        group.saved, share(group.saved, explanation.cost), group.disagreements,
                        counted(group.states, "state"), group.mended, group.spoilt);
    text += fmt::format("   {}\n", suggestion.edit);
  }
  std::vector<std::string> titles{"now"};
  std::vector<TreeFigures> figures{report.now};
  for (std::size_t i = 0; i < report.suggestions.size(); ++i) {
    titles.push_back(i == 0 ? "with 1" : fmt::format("with 1 to {}", i + 1));
    figures.push_back(report.suggestions[i].together);
  }
  text += '\n' + side_by_side(titles, figures);
  return text + fmt::format("with all of them:\n{}\n", to_text(report.suggestions.back().together_tree, vocabulary));
}

Json to_json(const ExplainReport& report, const Chain& chain, const Tree& tree, std::size_t most_states) {
  const Explanation& explanation = report.explanation;
  const Vocabulary& vocabulary = chain.vocabulary();
  Json states = Json::array();
  for (std::size_t i = 0; i < std::min(most_states, explanation.disagreements.size()); ++i) {
    const Disagreement& d = explanation.disagreements[i];
    states.push_back({{"state", d.state},
                      {"observation", observation_text(vocabulary, chain.features_of(d.state))},
                      {"cost", d.cost()},
                      {"visits", d.visits},
                      {"regret", d.regret},
                      {"policy", action_text(vocabulary, d.policy)},
                      {"tree", action_text(vocabulary, d.tree)},
                      {"node", d.writer == kTickEnds ? Json(nullptr) : Json(d.writer)}});
  }
  Json groups = Json::array();
  for (std::size_t i = 0; i < explanation.groups.size(); ++i) {
    const Group& group = explanation.groups[i];
    const Suggestion& suggestion = report.suggestions[i];
    groups.push_back({{"when", condition_text(group, vocabulary)},
                      {"action", action_text(vocabulary, group.action)},
                      {"saved", group.saved},
                      {"states", group.states},
                      {"disagreements", group.disagreements},
                      {"mended", group.mended},
                      {"spoilt", group.spoilt},
                      {"branch", to_text(suggestion.branch, vocabulary)},
                      {"edit", suggestion.edit},
                      {"alone", json_of(suggestion.alone)},
                      {"together", json_of(suggestion.together)},
                      {"tree", to_text(suggestion.together_tree, vocabulary)}});
  }
  return {{"tree", to_text(tree, vocabulary)},
          {"weights", name_of(explanation.settings.weighting)},
          {"steps", explanation.settings.steps},
          {"states", explanation.states},
          {"disagreements", explanation.disagreements.size()},
          {"cost", explanation.cost},
          {"now", json_of(report.now)},
          {"costliest", states},
          {"complete", explanation.complete},
          {"groups", groups}};
}

}  // namespace coppice
