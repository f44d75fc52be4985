// The parts of GuidedClimb that leave local optima: leaps, and the beam.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "common/evolution/guided_climb.hpp"
#include "common/tree/tree_size.hpp"

namespace coppice {
namespace {

constexpr std::size_t kLeapsOfKind = 24;  // edits of a kind that a leap may begin with
constexpr std::size_t kLeapTries = 5;     // edits that are evaluated in an ascent after a leap before it ends
constexpr std::uint32_t kLeapSteps = 12;  // of such an ascent
constexpr double kLeastLeap = 1e-8;       // of the worth, relative: less is not worth a leap
constexpr std::size_t kBeam = 12;         // trees of a level that the next one begins with
constexpr std::size_t kExpanded = 40;     // edits that each of them is tried with
constexpr std::size_t kLevels = 8;        // conditions up to which a beam goes
constexpr std::size_t kNodesOfTest = 4;   // that a binary decision tree has for a test, with its share of actions

std::vector<Node> conditions_of(const Vocabulary& vocabulary) {
  std::vector<Node> conditions;
  for (std::size_t f = 0; f < vocabulary.features.size(); ++f) {
    for (const std::uint8_t value : vocabulary.features[f].values) {
      for (const Op op : {Op::equal, Op::less_equal}) {
        if (vocabulary.features[f].admits(op)) {
          conditions.push_back(Node::condition(f, op, value));
        }
      }
    }
  }
  return conditions;
}

}  // namespace

// Where a leap may begin, what loses least first.
std::vector<RankedEdit> GuidedClimb::leaps(const Tree& tree, const EditLimits& limits) {
  std::vector<RankedEdit> result;
  const std::vector<Node> conditions = conditions_of(chain_.vocabulary());
  for (std::size_t node = 0; node < tree.size(); ++node) {
    if (tree[node].kind != NodeKind::condition) {
      continue;
    }
    for (const Node& condition : conditions) {
      if (condition != tree[node]) {
        RankedEdit edit{0.0, tree.with_subtree(node, std::span<const Node>(&condition, 1))};
        fill(edit.tree, tried_);
        edit.gain = ranking_.gain_of(tried_, gains_);
        result.push_back(std::move(edit));
      }
    }
  }
  const auto add = [&](std::vector<RankedEdit> edits) {
    std::move(edits.begin(), edits.end(), std::back_inserter(result));
  };
  add(ranking_.best_of_two_conditions(tree, gains_, limits, kLeapsOfKind));
  if (const std::size_t count = condition_count(tree.nodes()); count > 0) {
    EditLimits smaller = limits;
    smaller.max_conditions = count - 1;
    add(ranking_.best(tree, gains_, smaller, kLeapsOfKind));
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const RankedEdit& a, const RankedEdit& b) { return a.gain > b.gain; });
  return result;
}

// True: a climb from some edit, however bad, led higher. REQUIRES: the gains are those of reached.tree, or of one that
// means the same.
bool GuidedClimb::leap(Reached& reached, const EditLimits& limits, std::uint64_t until) {
  if (!stand_on(reached.tree)) {
    return false;
  }
  for (RankedEdit& edit : leaps(reached.tree, limits)) {
    if (solved_ >= until) {
      return false;
    }
    fill(edit.tree, tried_);
    if (passed_.count(meaning_of(tried_)) > 0) {
      continue;
    }
    Reached other{std::move(edit.tree), 0.0};
    const auto worth = stand_on(other.tree);
    if (!worth) {
      continue;
    }
    other.worth = *worth;
    ascend(other, limits, {.steps = kLeapSteps, .tries = kLeapTries, .pairs = false, .merges = true});
    if (other.worth > reached.worth + kLeastLeap * std::abs(reached.worth)) {
      reached = std::move(other);
      return true;
    }
  }
  return false;
}

// Local optima that begin with the beam's trees and one more condition, or two.
std::vector<GuidedClimb::Reached> GuidedClimb::grown(const std::vector<Reached>& beam, const EditLimits& limits,
                                                     std::uint64_t until) {
  std::vector<Reached> found;
  passed_.clear();
  for (const Reached& member : beam) {
    if (solved_ >= until || !stand_on(member.tree)) {
      continue;
    }
    std::vector<RankedEdit> edits = ranking_.best(member.tree, gains_, limits, kExpanded);
    for (RankedEdit& edit : ranking_.best_of_two_conditions(member.tree, gains_, limits, kExpanded / 2)) {
      edits.push_back(std::move(edit));
    }
    for (RankedEdit& edit : edits) {
      fill(edit.tree, tried_);
      if (solved_ >= until || passed_.count(meaning_of(tried_)) > 0) {
        continue;
      }
      Reached other{std::move(edit.tree), 0.0};
      if (const auto worth = stand_on(other.tree)) {
        other.worth = *worth;
        ascend(other, limits, {.steps = kLeapSteps, .tries = kLeapTries, .pairs = false, .merges = true});
        found.push_back(std::move(other));
      }
    }
  }
  return found;
}

std::vector<Tree> GuidedClimb::explore(std::span<const double> worth, const EditLimits& limits,
                                       std::uint64_t evaluations) {
  begin(worth);
  std::vector<Reached> beam;
  for (std::size_t a = 0; a < chain_.actions(); ++a) {
    Reached start{Tree(ActionId{static_cast<std::uint8_t>(a)}), 0.0};
    if (const auto at_start = stand_on(start.tree)) {
      start.worth = *at_start;
      beam.push_back(std::move(start));
    }
  }
  const std::size_t levels = std::min({kLevels, limits.max_conditions, (limits.max_nodes - 1) / 2});
  const std::uint64_t before = solved_;
  for (std::size_t level = 1; level <= levels; ++level) {
    EditLimits so_far = limits;
    so_far.max_conditions = level;
    so_far.max_nodes = std::min(limits.max_nodes, kNodesOfTest * level + 1);
    std::vector<Reached> next = grown(beam, so_far, before + evaluations * level / levels);
    std::move(beam.begin(), beam.end(), std::back_inserter(next));
    std::stable_sort(next.begin(), next.end(), [](const Reached& a, const Reached& b) { return a.worth > b.worth; });
    beam.clear();
    std::unordered_set<Meaning, MeaningHash> kept;
    for (Reached& member : next) {
      fill(member.tree, tried_);
      if (beam.size() < kBeam && kept.insert(meaning_of(tried_)).second) {
        beam.push_back(std::move(member));
      }
    }
  }
  std::vector<Tree> trees;
  trees.reserve(beam.size());
  for (Reached& member : beam) {
    trees.push_back(std::move(member.tree));
  }
  return trees;
}

}  // namespace coppice
