#include "coordinator/runs/answer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "common/chain/exact.hpp"
#include "common/check.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/runs/learn_study.hpp"
#include "coordinator/runs/simulate_study.hpp"

namespace coppice {
namespace {

// How much a race may take. A step of our own worlds takes a tenth of a microsecond; of a problem's own simulator, a
// program that speaks JSON, tens of microseconds, and it is started for every tree.
struct RaceSize {
  std::size_t most_tried;               // trees of a front
  std::array<std::uint64_t, 4> rounds;  // episodes of each tree, all rounds before included
  std::uint64_t fresh;                  // episodes that measure the answer
};
constexpr RaceSize kInside = {40, {40, 160, 400, 800}, 500};
constexpr RaceSize kOutside = {16, {10, 30, 100, 200}, 200};
constexpr std::size_t kNeverDropped = 3;                           // that a round leaves at least
constexpr std::uint64_t kRaceEpisodes = std::uint64_t{1} << 40U;   // where the numbers of the race's episodes begin
constexpr std::uint64_t kFreshEpisodes = std::uint64_t{1} << 41U;  // of those that measure the answer
constexpr double kEnough = 0.9;      // share of the policy's reward below which a tree is not good enough
constexpr double kNearlyAll = 0.97;  // the same that is asked of the smallest tree
constexpr double kUnmeasured = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-9;  // of what is computed on the chain
constexpr double kAsMuch = 0.005;   // share of the reward that nobody minds, for a smaller tree
constexpr double kSameSteps = 0.5;  // agreement below which a tree explains nothing

template <typename Of>
std::vector<double> per_episode(const std::vector<EpisodeRecord>& episodes, const Of& of) {
  std::vector<double> values;
  values.reserve(episodes.size());
  for (const EpisodeRecord& episode : episodes) {
    values.push_back(of(episode));
  }
  return values;
}

double reward_of(const EpisodeRecord& episode) { return episode.reward; }
double agreement_in(const EpisodeRecord& episode) {
  return static_cast<double>(episode.matches) / static_cast<double>(std::max<std::uint32_t>(1, episode.steps));
}
double collisions_in(const EpisodeRecord& episode) { return episode.collisions; }

Worth worth_of(const std::vector<EpisodeRecord>& episodes) {
  return {estimate(per_episode(episodes, reward_of)), estimate(per_episode(episodes, agreement_in)),
          estimate(per_episode(episodes, collisions_in))};
}

// As safe as the policy: no collision where it has none, or not clearly more than it has.
bool is_safe(const Worth& tree, const Worth& policy) {
  return policy.collisions.mean == 0.0
             ? tree.collisions.mean == 0.0
             : tree.collisions.mean - tree.collisions.margin <= policy.collisions.mean + policy.collisions.margin;
}

// What the chain says, exactly: the measures of a member, and of the policy as if it were one.
class OnChain {
 public:
  OnChain(const Study& study, const Front& front, const EvolveConfig& config) : front_(front) {
    // Measured as the mean a step times rollout.steps.
    if (config.rollout.method == Method::discounted) {
      unit_ = 1.0 / ((1.0 - config.rollout.gamma) * config.rollout.steps);
    }
    const Chain& chain = study.chain();
    policy_.agreement.mean = 1.0;
    policy_.reward.mean = unit_ * along_policy(chain, config, ObjectiveKind::expected_return);
    if (const auto& known = front.measures;
        std::find(known.begin(), known.end(), measure_of(ObjectiveKind::collisions)) != known.end()) {
      policy_.collisions.mean = along_policy(chain, config, ObjectiveKind::collisions);
    }
  }

  double of(std::size_t member, ObjectiveKind kind, double otherwise) const {
    return value_of(front_, front_.members[member], measure_of(kind)).value_or(otherwise);
  }
  Worth of(std::size_t member) const {
    return {{unit_ * of(member, ObjectiveKind::expected_return, front_.members[member].fitness), 0.0},
            {of(member, ObjectiveKind::agreement, kUnmeasured), 0.0},
            {of(member, ObjectiveKind::collisions, 0.0), 0.0}};
  }
  const Worth& policy() const { return policy_; }

 private:
  // A walk's worth of it, as Measuring has it; 0 where it cannot be computed.
  static double along_policy(const Chain& chain, const EvolveConfig& config, ObjectiveKind kind) {
    const Objective objective{kind, {}, kind == ObjectiveKind::collisions ? config.fitness.collision_reward : 0.0};
    const auto table = make_score_table(chain, objective);
    const RolloutConfig& rollout = config.rollout;
    const bool solved = rollout.method == Method::discounted || rollout.method == Method::long_run;
    if (!table || (solved && chain.states() > kMaxSolvedStates)) {
      return 0.0;
    }
    std::vector<std::uint8_t> actions;
    actions.reserve(chain.states());
    for (std::size_t s = 0; s < chain.states(); ++s) {
      actions.push_back(static_cast<std::uint8_t>(index_of(chain.policy(s))));
    }
    ExactOccupancy exact(chain);
    const ActingTables acting{.actions = actions, .others = {}};
    const Occupancy* occupancy = rollout.method == Method::discounted ? exact.discounted(acting, rollout.gamma)
                                 : rollout.method == Method::long_run ? exact.long_run(acting)
                                                                      : &exact.over_steps(acting, rollout.steps);
    double sum = 0.0;
    for (std::size_t i = 0; occupancy != nullptr && i < occupancy->states.size(); ++i) {
      const std::uint32_t state = occupancy->states[i];
      sum += occupancy->visits[i] * static_cast<double>(table->scores[state * (chain.actions() + 1) + actions[state]]);
    }
    return sum / table->unit * (solved ? static_cast<double>(rollout.steps) : 1.0);
  }

  const Front& front_;
  double unit_ = 1.0;
  Worth policy_;
};

struct Candidate {
  std::size_t member = 0;
  std::size_t nodes = 0;
  double coverage = 0.0;
  std::vector<EpisodeRecord> episodes;
  Worth worth;
};

// The order among candidates that are all safe.
class Preference {
 public:
  Preference(Prefer prefer, const Worth& policy) : prefer_(prefer), policy_(policy) {}

  // The larger, the better; what comes first in the pair decides.
  std::pair<double, double> of(const Candidate& candidate) const {
    const double reward = candidate.worth.reward.mean;
    switch (prefer_) {
      case Prefer::agreement:
        return {candidate.worth.agreement.mean, reward};
      case Prefer::coverage:
        return {candidate.coverage, reward};
      case Prefer::size: {
        const bool enough = reward >= policy_.reward.mean - (1.0 - kNearlyAll) * std::abs(policy_.reward.mean);
        return {enough ? 1.0 : 0.0, enough ? -static_cast<double>(candidate.nodes) : reward};
      }
      case Prefer::balance:
        return {candidate.worth.agreement.mean >= kSameSteps ? 1.0 : 0.0, reward};
      case Prefer::expected_return:
      case Prefer::pick:
        break;
    }
    return {reward, 0.0};
  }

  // What may still turn out better than `best`: the difference is within its interval.
  bool in_question(const Candidate& candidate, const Candidate& best) const {
    if (prefer_ == Prefer::coverage) {  // known without an episode
      return true;
    }
    const Estimate difference = estimate(differences(candidate, best));
    return difference.mean + difference.margin >= 0.0;
  }

  // Whether a smaller tree is as good as the best.
  bool as_good(const Candidate& smaller, const Candidate& best) const {
    if (prefer_ == Prefer::coverage || prefer_ == Prefer::size || of(smaller).first < of(best).first) {
      return of(smaller) == of(best);
    }
    const Estimate difference = estimate(differences(smaller, best));
    const double scale = prefer_ == Prefer::agreement ? 1.0 : std::abs(best.worth.reward.mean);
    return difference.mean >= -(best.episodes.empty() ? kRounding : kAsMuch) * scale;
  }

 private:
  std::vector<double> differences(const Candidate& a, const Candidate& b) const {
    const auto of = prefer_ == Prefer::agreement ? agreement_in : reward_of;
    std::vector<double> result;
    for (std::size_t e = 0; e < std::min(a.episodes.size(), b.episodes.size()); ++e) {
      result.push_back(of(a.episodes[e]) - of(b.episodes[e]));
    }
    if (result.empty()) {  // on the chain
      result.push_back(prefer_ == Prefer::agreement ? a.worth.agreement.mean - b.worth.agreement.mean
                                                    : a.worth.reward.mean - b.worth.reward.mean);
    }
    return result;
  }

  Prefer prefer_;
  const Worth& policy_;
};

class Choice {
 public:
  Choice(const Study& study, const Front& front, const EvolveConfig& config, const AnswerProgress& progress)
      : study_(study),
        front_(front),
        config_(config),
        progress_(progress),
        chain_(study, front, config),
        outside_(!study.problem().simulator.empty()),
        size_(outside_ ? kOutside : kInside),
        settings_{.episodes = 0,
                  .steps = has_simulator(study) && !outside_ ? learned_steps(study) : config.rollout.steps,
                  .seed = config.seed,
                  .stop = progress.stop} {}

  Result<Answer> make() {
    Answer answer;
    answer.prefer = config_.front.prefer;
    answer.simulated = has_simulator(study_);
    gather();
    if (answer.simulated) {
      auto world = world_of(study_);
      if (!world) {
        return tl::unexpected(world.error());
      }
      world_ = std::move(*world);
      if (auto ok = race(); !ok) {
        return tl::unexpected(ok.error());
      }
    } else {
      policy_ = chain_.policy();
      keep_safe();
      sort();
    }
    answer.tried = tried_;
    while (true) {
      const Candidate& chosen = smallest_as_good();
      answer.member = chosen.member;
      answer.tree = chosen.worth;
      answer.policy = policy_;
      answer.on_chain = chain_.of(chosen.member).reward.mean;
      answer.policy_on_chain = chain_.policy().reward.mean;
      if (!answer.simulated) {
        break;
      }
      if (auto ok = measure_afresh(answer); !ok) {
        return tl::unexpected(ok.error());
      }
      // What was safe by luck gives way to the next.
      if (is_safe(answer.tree, answer.policy) || candidates_.size() == 1) {
        break;
      }
      std::erase_if(candidates_, [&](const Candidate& candidate) { return candidate.member == answer.member; });
    }
    judge(answer);
    return answer;
  }

 private:
  // On episodes that had no say in the race.
  Result<void> measure_afresh(Answer& answer) {
    settings_.episodes = size_.fresh;
    settings_.first_episode = kFreshEpisodes;
    const auto tree =
        simulate_tree(*world_, study_.chain(), front_.members[answer.member].tree, settings_, progress_.go_on);
    if (!tree) {
      return tl::unexpected(tree.error());
    }
    const auto policy = simulate_policy(*world_, study_.chain(), settings_, progress_.go_on);
    if (!policy) {
      return tl::unexpected(policy.error());
    }
    answer.episodes = size_.fresh;
    answer.tree = worth_of(*tree);
    answer.policy = worth_of(*policy);
    return {};
  }

  // Those of the front that are worth trying: the first by each of several orders, the ones that the chain calls safe
  // before the others.
  void gather() {
    std::vector<std::size_t> all(front_.members.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    const auto unsafe = [&](std::size_t member) {
      return chain_.of(member, ObjectiveKind::collisions, 0.0) > chain_.policy().collisions.mean + 1e-9;
    };
    const auto value = [&](std::size_t member, int order) {
      switch (order) {
        case 0:
          return chain_.of(member).reward.mean;
        case 1:
          return chain_.of(member, ObjectiveKind::agreement, 0.0);
        case 2:
          return chain_.of(member, ObjectiveKind::coverage, 0.0);
        case 3:
          return front_.members[member].fitness;
        default:
          return -chain_.of(member, ObjectiveKind::unknown, 0.0);
      }
    };
    constexpr int kOrders = 5;
    std::vector<std::vector<std::size_t>> orders;
    for (int order = 0; order < kOrders; ++order) {
      std::stable_sort(all.begin(), all.end(), [&](std::size_t a, std::size_t b) {
        return unsafe(a) != unsafe(b) ? unsafe(b) : value(a, order) > value(b, order);
      });
      orders.push_back(all);
    }
    std::vector<bool> taken(front_.members.size(), false);
    for (std::size_t rank = 0; rank < front_.members.size() && candidates_.size() < size_.most_tried; ++rank) {
      for (const std::vector<std::size_t>& order : orders) {
        const std::size_t member = order[rank];
        if (!taken[member] && candidates_.size() < size_.most_tried) {
          taken[member] = true;
          candidates_.push_back({.member = member,
                                 .nodes = front_.members[member].tree.size(),
                                 .coverage = chain_.of(member, ObjectiveKind::coverage, 0.0),
                                 .episodes = {},
                                 .worth = chain_.of(member)});
        }
      }
    }
    tried_ = candidates_.size();
  }

  // Every candidate meets the same episodes; after each round those that are clearly worse go.
  Result<void> race() {
    settings_.first_episode = kRaceEpisodes;
    std::vector<EpisodeRecord> of_policy;
    for (const std::uint64_t until : size_.rounds) {
      settings_.episodes = until - (settings_.first_episode - kRaceEpisodes);
      auto policy = simulate_policy(*world_, study_.chain(), settings_, progress_.go_on);
      if (!policy) {
        return tl::unexpected(policy.error());
      }
      of_policy.insert(of_policy.end(), policy->begin(), policy->end());
      policy_ = worth_of(of_policy);
      for (Candidate& candidate : candidates_) {
        const Tree& tree = front_.members[candidate.member].tree;
        auto episodes = simulate_tree(*world_, study_.chain(), tree, settings_, progress_.go_on);
        if (!episodes) {
          return tl::unexpected(episodes.error());
        }
        candidate.episodes.insert(candidate.episodes.end(), episodes->begin(), episodes->end());
        candidate.worth = worth_of(candidate.episodes);
      }
      settings_.first_episode = kRaceEpisodes + until;
      keep_safe();
      sort();
      drop_the_worse();
      if (candidates_.size() == 1) {
        break;
      }
    }
    return {};
  }

  // Where none is safe, the ones with the fewest collisions.
  void keep_safe() {
    const auto unsafe = [&](const Candidate& candidate) { return !is_safe(candidate.worth, policy_); };
    if (std::all_of(candidates_.begin(), candidates_.end(), unsafe)) {
      const auto least = std::min_element(candidates_.begin(), candidates_.end(), [](const auto& a, const auto& b) {
        return a.worth.collisions.mean < b.worth.collisions.mean;
      });
      const double limit = least->worth.collisions.mean + least->worth.collisions.margin;
      std::erase_if(candidates_, [&](const Candidate& candidate) { return candidate.worth.collisions.mean > limit; });
    } else {
      std::erase_if(candidates_, unsafe);
    }
  }

  void sort() {
    const Preference preference(config_.front.prefer, policy_);
    std::stable_sort(candidates_.begin(), candidates_.end(), [&](const Candidate& a, const Candidate& b) {
      return preference.of(a) != preference.of(b) ? preference.of(a) > preference.of(b) : a.nodes < b.nodes;
    });
  }

  // Whether the candidate has done in every episode what the other did, and is no smaller: where all are perfect, say.
  bool no_other(const Candidate& other, const Candidate& candidate) const {
    const auto same = [](const EpisodeRecord& a, const EpisodeRecord& b) {
      return a.reward == b.reward && a.steps == b.steps && a.matches == b.matches && a.collisions == b.collisions;
    };
    return other.nodes <= candidate.nodes && other.coverage >= candidate.coverage &&
           std::equal(other.episodes.begin(), other.episodes.end(), candidate.episodes.begin(),
                      candidate.episodes.end(), same);
  }

  void drop_the_worse() {
    const Preference preference(config_.front.prefer, policy_);
    std::vector<Candidate> kept;
    for (Candidate& candidate : candidates_) {
      if (std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) { return no_other(other, candidate); })) {
        continue;
      }
      if (kept.size() < kNeverDropped ||
          (config_.front.prefer == Prefer::size && preference.of(candidate).first > 0.0) ||
          (config_.front.prefer != Prefer::size && preference.in_question(candidate, kept.front()))) {
        kept.push_back(std::move(candidate));
      }
    }
    candidates_ = std::move(kept);
  }

  const Candidate& smallest_as_good() const {
    COPPICE_CHECK(!candidates_.empty());
    const Preference preference(config_.front.prefer, policy_);
    const Candidate* smallest = &candidates_.front();
    for (const Candidate& candidate : candidates_) {
      if (candidate.nodes < smallest->nodes && preference.as_good(candidate, candidates_.front())) {
        smallest = &candidate;
      }
    }
    return *smallest;
  }

  // Whether a person should use the tree; if not, why, and what to try.
  void judge(Answer& answer) const {
    const double scale = std::abs(answer.policy.reward.mean);
    const double short_by = answer.policy.reward.mean - answer.tree.reward.mean;
    const bool unsafe = !is_safe(answer.tree, answer.policy);
    const bool earns_little = short_by > (1.0 - kEnough) * scale + 1e-9;
    answer.good = !unsafe && !earns_little;
    if (answer.good) {
      return;
    }
    if (unsafe) {
      answer.notes.push_back(fmt::format("it collides {:.3f} times an episode, the policy {:.3f} times",
                                         answer.tree.collisions.mean, answer.policy.collisions.mean));
    }
    if (earns_little) {
      answer.notes.push_back(fmt::format("it earns {:.1f} where the policy earns {:.1f}", answer.tree.reward.mean,
                                         answer.policy.reward.mean));
    }
    const double chain_scale = std::max(std::abs(answer.policy_on_chain), 1e-9);
    const bool chain_content = answer.on_chain >= answer.policy_on_chain - (1.0 - kEnough) * chain_scale;
    if (answer.simulated && chain_content) {
      answer.notes.push_back(
          fmt::format("the chain promises {:.1f} (of the policy's {:.1f}): chain and simulator differ, because "
                      "learning was short or "
                      "states look alike to the tree; try longer learning (coppice learn --episodes), or coppice "
                      "refine, which counts "
                      "what the tree meets",
                      answer.on_chain, answer.policy_on_chain));
    } else {
      answer.notes.push_back(
          fmt::format("the search found nothing better within {} and {}; try more of them (--set ga.max_nodes=N --set "
                      "front.max_nodes=N), more generations, or several seeds",
                      counted(std::min(config_.ga.max_nodes, config_.front.max_nodes), "node"),
                      counted(config_.ga.generations, "generation")));
    }
  }

  const Study& study_;
  const Front& front_;
  const EvolveConfig& config_;
  const AnswerProgress& progress_;
  OnChain chain_;
  bool outside_;  // the problem has a simulator of its own
  RaceSize size_;
  SimulateSettings settings_;
  std::optional<World> world_;
  std::vector<Candidate> candidates_;
  std::size_t tried_ = 0;
  Worth policy_;
};

std::string with_margin(const Estimate& estimate, double factor, int digits) {
  return estimate.margin > 0.0
             ? fmt::format("{:.{}f} +- {:.{}f}", factor * estimate.mean, digits, factor * estimate.margin, digits)
             : fmt::format("{:.6g}", factor * estimate.mean);
}

}  // namespace

Result<Answer> choose_answer(const Study& study, const Front& front, const EvolveConfig& config,
                             const AnswerProgress& progress) {
  COPPICE_CHECK(!front.members.empty() && config.front.prefer != Prefer::pick);
  return Choice(study, front, config, progress).make();
}

std::string to_text(const Answer& answer) {
  std::string text = fmt::format(
      "chosen by {} among {}, {}:\n", name_of(answer.prefer), counted(answer.tried, "tree"),
      answer.simulated ? fmt::format("in the simulator; {} that chose nothing", counted(answer.episodes, "episode"))
                       : std::string("on the chain"));
  text += fmt::format("  reward {}, the policy's {}, gap {:.4g}", with_margin(answer.tree.reward, 1.0, 2),
                      with_margin(answer.policy.reward, 1.0, 2), answer.policy.reward.mean - answer.tree.reward.mean);
  if (answer.policy.reward.mean > 0.0) {
    text += fmt::format(" ({:.1f} %)", 100.0 * answer.tree.reward.mean / answer.policy.reward.mean);
  }
  text += '\n';
  if (!std::isnan(answer.tree.agreement.mean)) {
    text += fmt::format("  the policy's action in {} % of the steps\n", with_margin(answer.tree.agreement, 100.0, 1));
  }
  if (answer.simulated || answer.tree.collisions.mean > 0.0 || answer.policy.collisions.mean > 0.0) {
    text += fmt::format("  collisions an episode {}, the policy's {}\n", with_margin(answer.tree.collisions, 1.0, 3),
                        with_margin(answer.policy.collisions, 1.0, 3));
  }
  if (!answer.good) {
    text += "This tree is not good enough:\n";
    for (const std::string& note : answer.notes) {
      text += fmt::format("  {}\n", note);
    }
  }
  return text;
}

}  // namespace coppice
