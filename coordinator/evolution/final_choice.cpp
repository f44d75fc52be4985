#include "coordinator/evolution/final_choice.hpp"

#include <algorithm>

#include "common/check.hpp"
#include "common/evolution/dominance.hpp"
#include "common/evolution/evaluated.hpp"

namespace coppice {

Result<FinalChoice> FinalChoice::make(const Chain& chain, const EvolveConfig& config) {
  const bool front = config.ga.search == Search::front;
  auto fitness = ScalarFitness::make(chain, config.fitness, front ? config.front.objectives : std::vector<Measure>());
  if (!fitness) {
    return tl::unexpected(fitness.error());
  }
  FinalChoice choice(config, std::move(*fitness));
  if (front) {
    auto gauge = FrontGauge::make(chain, config);
    if (!gauge) {
      return tl::unexpected(gauge.error());
    }
    choice.gauge_ = std::move(*gauge);
    auto rule = parse_pick(config.front.pick);
    if (!rule) {
      return tl::unexpected(rule.error());
    }
    choice.rule_ = std::move(*rule);
  }
  return choice;
}

std::vector<Individual> FinalChoice::united_archive(std::span<const std::shared_ptr<const Deme>> demes) const {
  std::vector<Individual> united;
  if (!gauge_) {
    return united;
  }
  FrontArchive archive;
  for (const auto& deme : demes) {
    for (const Individual& member : deme->archive) {
      archive.offer(gauge_->of(member), config_.front.max_nodes);
    }
  }
  archive.thin(config_.front.objectives.size(), config_.front.members);
  for (const FrontIndividual& member : archive.members()) {
    united.push_back({member.tree, member.tally});
  }
  return united;
}

std::vector<Tree> FinalChoice::finalists(const Reached& reached) const {
  std::vector<Tree> trees;
  if (gauge_) {
    for (const Individual& member : reached.archive) {
      trees.push_back(member.tree);
    }
  } else {
    for (const Champion& champion : reached.hall_of_fame) {
      trees.push_back(champion.tree);
    }
  }
  return trees;
}

Job FinalChoice::job() const { return job_of(config_, fitness_.objectives(), kFinalGeneration); }

Evolved FinalChoice::answer(const Reached& reached, std::vector<Tally> tallies) const {
  std::vector<Tree> trees = finalists(reached);
  COPPICE_CHECK(tallies.size() == trees.size());
  if (gauge_) {
    std::vector<Individual> kept;
    kept.reserve(trees.size());
    for (std::size_t i = 0; i < trees.size(); ++i) {
      kept.push_back({std::move(trees[i]), std::move(tallies[i])});
    }
    return of_front(reached, std::move(kept), false);
  }
  const Evaluated champions = Evaluated::of(std::move(trees), std::move(tallies), fitness_);
  const std::size_t best = champions.best();
  const std::uint32_t first_led = reached.hall_of_fame[best].generation;
  return Evolved{champions.champion(best, first_led), champions.tallies[best].steps, reached.generations, false};
}

Evolved FinalChoice::interrupted(const Reached& reached) const {
  if (gauge_) {
    return of_front(reached, reached.archive, true);
  }
  return Evolved{best_on_record(reached.hall_of_fame), 0, reached.generations, true};
}

Evolved FinalChoice::of_front(const Reached& reached, std::vector<Individual> individuals, bool interrupted) const {
  std::vector<FrontIndividual> kept;
  kept.reserve(individuals.size());
  for (Individual& individual : individuals) {
    kept.push_back(gauge_->of(std::move(individual)));
  }
  const std::vector<double> values = costs_of(kept);
  const std::vector<std::uint32_t> ranks = ranks_of({values, config_.front.objectives.size()});
  std::vector<const FrontIndividual*> members;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (ranks[i] == 0 && kept[i].tally.steps > 0) {
      members.push_back(&kept[i]);
    }
  }
  std::stable_sort(members.begin(), members.end(), [](const FrontIndividual* a, const FrontIndividual* b) {
    return a->tree.size() != b->tree.size() ? a->tree.size() < b->tree.size() : a->fitness > b->fitness;
  });
  Evolved evolved;
  evolved.generations_done = reached.generations;
  evolved.interrupted = interrupted;
  evolved.front.measures = gauge_->measures();
  for (const FrontIndividual* member : members) {
    evolved.front.members.push_back({member->tree, member->fitness, gauge_->values(member->tree, member->tally)});
  }
  auto chosen = pick(evolved.front, rule_);
  evolved.pick_fits = chosen.has_value();
  if (members.empty()) {  // no tree was small enough for the front
    evolved.best = best_on_record(reached.hall_of_fame);
    return evolved;
  }
  if (!chosen) {
    chosen = pick(evolved.front, PickRule{});
  }
  const FrontIndividual& best = *members[*chosen];
  evolved.best = {best.tree, reached.generations - 1, best.fitness, agreement_of(best.tally)};
  evolved.final_steps = interrupted ? 0 : best.tally.steps;
  return evolved;
}

}  // namespace coppice
