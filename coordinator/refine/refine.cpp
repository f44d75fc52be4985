#include "coordinator/refine/refine.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/check.hpp"
#include "common/evolution/breeding.hpp"
#include "common/evolution/seeding.hpp"
#include "common/tree/text.hpp"
#include "coordinator/console/counted.hpp"
#include "coordinator/console/json_line.hpp"

namespace coppice {
namespace {

// The trees of the last front that this tree is on; none where it is on no front.
Result<std::vector<Tree>> front_around(const Study& study, const Tree& tree) {
  const auto runs = study.runs();
  if (!runs) {
    return tl::unexpected(runs.error());
  }
  for (auto run = runs->rbegin(); run != runs->rend(); ++run) {
    const auto front = study.front(run->id);
    if (!front) {
      return tl::unexpected(front.error());
    }
    std::vector<Tree> trees;
    for (const FrontMember& member : front->members) {
      trees.push_back(member.tree);
    }
    if (std::find(trees.begin(), trees.end(), tree) != trees.end()) {
      return trees;
    }
  }
  return std::vector<Tree>();
}

// At most half a generation, so that new blood is left; of a larger front every so-manieth, small to large.
Result<std::string> founders_of_round(const Study& study, const Tree& tree, const Tree& best,
                                      const EvolveConfig& config) {
  const Vocabulary& vocabulary = study.chain().vocabulary();
  auto founders = founders_of(config.ga, vocabulary);
  const auto front = front_around(study, tree);
  if (!founders || !front) {
    return tl::unexpected(founders ? front.error() : founders.error());
  }
  const Breeding breeding(vocabulary, config.ga.shape());
  const auto add = [&](const Tree& candidate) {
    if (breeding.within_limits(candidate) &&
        std::find(founders->begin(), founders->end(), candidate) == founders->end()) {
      founders->push_back(candidate);
    }
  };
  const std::size_t most = std::max<std::size_t>(config.ga.population / 2, founders->size());
  for (const Tree* first : {&tree, &best}) {
    if (founders->size() < most) {
      add(*first);
    }
  }
  const std::size_t room = std::min(most - founders->size(), front->size());
  for (std::size_t i = 0; i < room; ++i) {
    add((*front)[i * front->size() / room]);
  }
  return founders_text(*founders, vocabulary);
}

// How the round's chain came about, behind what the study says of its own.
StudyLearning with_round(const StudyLearning& learning, const Study& from, const Tree& tree,
                         const SimulateSettings& walks, const Gains& gains) {
  auto outcome = nlohmann::ordered_json::parse(learning.outcome, nullptr, false);
  if (!outcome.is_object()) {
    outcome = nlohmann::ordered_json::object();
  }
  outcome["refined"].push_back({{"from_chain", from.chain_hash().hex()},
                                {"tree", to_text(tree, from.chain().vocabulary())},
                                {"episodes", walks.episodes},
                                {"first_episode", walks.first_episode},
                                {"steps_per_episode", walks.steps},
                                {"seed", walks.seed},
                                {"steps", gains.steps}});
  return {learning.settings, json_line(outcome)};
}

bool better(const Score& one, const Score& other) {
  return one.tree.total_collisions != other.tree.total_collisions
             ? one.tree.total_collisions < other.tree.total_collisions
             : one.tree.reward.mean > other.tree.reward.mean;
}

class Refinement {
 public:
  Refinement(const World& world, const EvolveConfig& config, const RefineSettings& settings,
             const std::filesystem::path& folder, const RefineHooks& hooks)
      : world_(world), config_(config), settings_(settings), folder_(folder), hooks_(hooks) {}

  Result<void> run(const Study& study, Tree tree) {
    best_ = tree;
    if (auto ok = report(study, tree, {.round = 0, .seed = config_.seed}); !ok) {
      return ok;
    }
    std::optional<Study> last;
    for (std::uint32_t round = 1; round <= settings_.rounds; ++round) {
      auto next = run_round(last ? *last : study, round, tree);
      if (!next) {
        return tl::unexpected(next.error());
      }
      last.emplace(std::move(*next));
    }
    return {};
  }

 private:
  // The round's study, evolved; `tree` becomes its answer.
  Result<Study> run_round(const Study& from, std::uint32_t round, Tree& tree) {
    if (hooks_.walking) {
      hooks_.walking(round);
    }
    SimulateSettings walks = settings_.walks;
    walks.first_episode = std::uint64_t{round} << 32U;  // the score's are below, and no two rounds share one
    Experience experience(from.chain());
    const auto go_on = [&] { return !experience.lacks_collisions() && (!hooks_.go_on || hooks_.go_on()); };
    const auto episodes = simulate_tree(world_, from.chain(), tree, walks, go_on,
                                        [&](const SimulatedStep& step) { experience.add(step); });
    if (!episodes && !experience.lacks_collisions()) {
      return tl::unexpected(episodes.error());
    }
    auto extended = experience.extended();
    if (!extended) {
      return in_context(fmt::format("round {}", round), extended.error());
    }
    EvolveConfig config = config_;
    config.seed += round;
    auto founders = founders_of_round(from, tree, best_, config);
    if (!founders) {
      return tl::unexpected(founders.error());
    }
    config.ga.founders = std::move(*founders);
    const Gains gains = extended->gains;
    auto study = Study::create(study_of_round(folder_, round).string(), extended->chain, from.world(),
                               with_round(from.learning(), from, tree, walks, gains), from.problem());
    if (!study) {
      return tl::unexpected(study.error());
    }
    auto answer = hooks_.evolve(*study, config);
    if (!answer) {
      return tl::unexpected(answer.error());
    }
    tree = std::move(answer->tree);
    RefineRound ended{.round = round, .seed = config.seed, .gains = gains};
    if (answer->interrupted) {
      describe(*study, ended);
      return interrupted();
    }
    if (auto ok = report(*study, tree, std::move(ended)); !ok) {
      return tl::unexpected(ok.error());
    }
    return study;
  }

  Result<void> report(const Study& study, const Tree& tree, RefineRound round) {
    auto score = score_tree(world_, study.chain(), tree, settings_.judged, hooks_.go_on);
    if (!score) {
      return tl::unexpected(score.error());
    }
    add_exact(study.chain(), tree, *score);
    round.score = std::move(*score);
    if (!best_score_ || better(*round.score, *best_score_)) {
      best_ = tree;
      best_score_ = round.score;
    }
    describe(study, round);
    return {};
  }

  void describe(const Study& study, RefineRound& round) const {
    round.study = study.path();
    round.chain = study.chain_hash().hex();
    round.states = study.chain().states();
    if (hooks_.round_done) {
      hooks_.round_done(round);
    }
  }

  const World& world_;
  const EvolveConfig& config_;
  const RefineSettings& settings_;
  const std::filesystem::path& folder_;
  const RefineHooks& hooks_;
  Tree best_{ActionId{0}};  // as best_of()
  std::optional<Score> best_score_;
};

}  // namespace

Result<void> check_settings(const RefineSettings& settings) {
  if (settings.rounds < 1 || settings.rounds > kMostRounds) {
    return bad_input(fmt::format("--rounds is {}: expected 1 to {}", settings.rounds, kMostRounds));
  }
  if (const auto checked = check_score_settings(settings.walks); !checked) {
    return checked;
  }
  return check_score_settings(settings.judged, "--score-episodes");
}

std::optional<std::size_t> best_of(const std::vector<RefineRound>& rounds) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < rounds.size(); ++i) {
    if (rounds[i].score && (!best || better(*rounds[i].score, *rounds[*best].score))) {
      best = i;
    }
  }
  return best;
}

std::filesystem::path study_of_round(const std::filesystem::path& folder, std::uint32_t round) {
  return folder / fmt::format("round-{}.coppice", round);
}

Result<void> refine(const Study& study, const World& world, const Tree& tree, const EvolveConfig& config,
                    const RefineSettings& settings, const std::filesystem::path& folder, const RefineHooks& hooks) {
  COPPICE_CHECK(hooks.evolve);
  return Refinement(world, config, settings, folder, hooks).run(study, tree);
}

}  // namespace coppice
