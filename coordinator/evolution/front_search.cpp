#include "coordinator/evolution/front_search.hpp"

#include <algorithm>
#include <chrono>
#include <unordered_map>

#include "common/check.hpp"
#include "common/fitness/meaning.hpp"
#include "coordinator/evolution/dominance.hpp"
#include "coordinator/evolution/evaluated.hpp"
#include "coordinator/evolution/front_individual.hpp"
#include "coordinator/evolution/population.hpp"
#include "coordinator/evolution/scalar_fitness.hpp"
#include "coordinator/evolution/selection.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMaxBirths = 6;      // of a child, until it means something new
constexpr double kWeighted = 0.5;  // probability that a parent is chosen by weights
constexpr double kUnmeasured = 1e300;

// The smallest tree of each meaning that there is.
class Known {
 public:
  // False: a tree that means the same and is no larger is there.
  bool add(const Meaning& meaning, std::size_t nodes) {
    const auto [found, added] = smallest_.emplace(meaning, nodes);
    if (!added && found->second <= nodes) {
      return false;
    }
    found->second = nodes;
    return true;
  }

 private:
  std::unordered_map<Meaning, std::size_t, MeaningHash> smallest_;
};

class FrontSearch {
 public:
  FrontSearch(const Chain& chain, const EvolveConfig& config, ScalarFitness fitness, Measuring measuring, PickRule rule,
              Evaluator& evaluator, const EvolveHooks& hooks)
      : chain_(chain),
        config_(config),
        fitness_(std::move(fitness)),
        measuring_(std::move(measuring)),
        rule_(std::move(rule)),
        breeding_(chain.vocabulary(), config.ga.shape()),
        meanings_(chain),
        evaluator_(evaluator),
        hooks_(hooks) {}

  Result<Evolved> run(std::optional<Checkpoint> start) {
    if (start) {
      if (auto ok = go_on_from(std::move(*start)); !ok) {
        return tl::unexpected(ok.error());
      }
    }
    while (done_ < config_.ga.generations) {
      if (auto ok = run_generation(done_); !ok) {
        return best_so_far(ok.error());
      }
    }
    return final_front();
  }

 private:
  // Measures everything anew: the sample is the same, so are the numbers.
  Result<void> go_on_from(Checkpoint start) {
    if (auto ok = check_checkpoint(start, config_.ga, breeding_); !ok) {
      return ok;
    }
    auto population = measured(std::move(start.population), kFrontGeneration);
    if (!population) {
      return tl::unexpected(population.error());
    }
    auto archive = measured(std::move(start.archive), kFrontGeneration);
    if (!archive) {
      return tl::unexpected(archive.error());
    }
    population_ = std::move(*population);
    archive_.assign(std::move(*archive));
    hall_ = std::move(start.hall_of_fame);
    done_ = start.generation + 1;
    return {};
  }

  Result<void> run_generation(std::uint32_t generation) {
    const Clock::time_point begin = Clock::now();
    const bool anew = generation % part_length() == 0 && generation / part_length() <= config_.front.restarts;
    std::vector<Tree> trees = anew ? begin_anew(generation) : breed(generation);
    const std::size_t evaluations = trees.size();
    auto children = measured(std::move(trees), kFrontGeneration);
    if (!children) {
      return tl::unexpected(children.error());
    }
    for (const FrontIndividual& child : *children) {
      archive_.offer(child, config_.front.max_nodes);
    }
    if (archive_.members().size() > config_.front.members) {
      keep_best(archive_.members(), costs(), config_.front.members);
    }
    std::move(children->begin(), children->end(), std::back_inserter(population_));
    if (!anew) {
      select_survivors();
    }
    done_ = generation + 1;
    GenerationRecord record = statistics_of(as_evaluated(population_), generation);
    record.evaluations = evaluations;
    enter(record.best, hall_);
    record.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return hooks_.generation_done ? hooks_.generation_done(record, checkpoint(generation)) : Result<void>();
  }

  // Generations between two beginnings.
  std::uint32_t part_length() const { return config_.ga.generations / (config_.front.restarts + 1); }
  bool in_last_part(std::uint32_t generation) const { return generation / part_length() >= config_.front.restarts; }

  // A first population; the last one has all that was kept.
  std::vector<Tree> begin_anew(std::uint32_t generation) {
    population_.clear();
    std::vector<Tree> trees = first_population(breeding_, config_, chain_, generation);
    const std::vector<FrontIndividual>& kept = archive_.members();
    for (std::size_t i = 0; i < std::min(kept.size(), trees.size()) && in_last_part(generation); ++i) {
      trees[i] = kept[i].tree;
    }
    return trees;
  }

  std::vector<Tree> breed(std::uint32_t generation) {
    const GaConfig& ga = config_.ga;
    Stream stream(config_.seed, Purpose::breeding, generation, 0);
    Known known;
    for (const FrontIndividual& individual : population_) {
      known.add(individual.meaning, individual.tree.size());
    }
    for (const FrontIndividual& member : archive_.members()) {
      if (in_last_part(generation)) {
        known.add(member.meaning, member.tree.size());
      }
    }
    const ParentPool population(population_, costs());
    const bool from_front = in_last_part(generation) && !archive_.members().empty();
    const ParentPool archive(from_front ? archive_.members() : population_, costs());
    std::vector<Tree> children;
    children.reserve(ga.population);
    while (children.size() < ga.population) {
      Tree child{ActionId{0}};
      for (int birth = 0; birth < kMaxBirths; ++birth) {
        child = make_child(stream, population, archive);
        if (ga.simplify == Simplification::lossless) {
          child = breeding_.simplified(child);
        }
        if (known.add(meanings_.of(child), child.size())) {
          break;
        }
      }
      children.push_back(std::move(child));
    }
    return children;
  }

  Tree make_child(Stream& stream, const ParentPool& population, const ParentPool& archive) const {
    const GaConfig& ga = config_.ga;
    const std::vector<double> weights = random_weights(stream, costs());
    const std::size_t size = tournament_size(ga.tournament, ga.population);
    if (stream.chance(ga.local_search)) {
      return breeding_.edit(stream, archive.by_weights(stream, weights, size).tree);
    }
    const auto parent = [&]() -> const Tree& {
      return (stream.chance(kWeighted) ? population.by_weights(stream, weights, size) : population.by_crowding(stream))
          .tree;
    };
    const Tree& mother = parent();
    if (!stream.chance(ga.crossover)) {
      return mutated(stream, breeding_, ga, mother);
    }
    Tree child = breeding_.crossover(stream, mother, parent()).first;
    return stream.chance(ga.mutation) ? mutated(stream, breeding_, ga, child) : child;
  }

  Result<std::vector<FrontIndividual>> measured(std::vector<Tree> trees, std::uint32_t generation) {
    auto evaluated = evaluate(std::move(trees), generation, config_, fitness_, evaluator_);
    if (!evaluated) {
      return tl::unexpected(std::move(evaluated).error());
    }
    std::vector<FrontIndividual> result;
    result.reserve(evaluated->trees.size());
    for (std::size_t i = 0; i < evaluated->trees.size(); ++i) {
      const Tally& tally = evaluated->tallies[i];
      result.push_back({.tree = std::move(evaluated->trees[i]),
                        .meaning = {},
                        .tally = tally,
                        .fitness = evaluated->fitness[i],
                        .costs = costs_of_tally(tally)});
      result.back().meaning = meanings_.of(result.back().tree);
    }
    return result;
  }

  static Evaluated as_evaluated(const std::vector<FrontIndividual>& individuals) {
    Evaluated result;
    for (const FrontIndividual& individual : individuals) {
      result.trees.push_back(individual.tree);
      result.tallies.push_back(individual.tally);
      result.fitness.push_back(individual.fitness);
    }
    return result;
  }

  std::size_t costs() const { return config_.front.objectives.size(); }

  std::vector<double> costs_of_tally(const Tally& tally) const {
    if (tally.steps == 0) {
      return std::vector<double>(costs(), kUnmeasured);
    }
    const std::vector<double> values = measuring_.values(tally);
    std::vector<double> costs;
    for (const Measure measure : config_.front.objectives) {
      const auto at = std::find(measuring_.measures().begin(), measuring_.measures().end(), measure);
      const double value = values[static_cast<std::size_t>(at - measuring_.measures().begin())];
      costs.push_back(is_cost(measure) ? value : -value);
    }
    return costs;
  }

  void select_survivors() {
    // A first generation, too, may hold what means the same: it goes first, as long as enough is left.
    Known known;
    const auto first_repeated = std::stable_partition(
        population_.begin(), population_.end(),
        [&](const FrontIndividual& individual) { return known.add(individual.meaning, individual.tree.size()); });
    const auto unlike = static_cast<std::size_t>(first_repeated - population_.begin());
    population_.resize(std::max<std::size_t>(unlike, config_.ga.population));
    keep_best(population_, costs(), config_.ga.population);
  }

  Checkpoint checkpoint(std::uint32_t generation) const {
    Checkpoint checkpoint;
    checkpoint.generation = generation;
    for (const FrontIndividual& individual : population_) {
      checkpoint.population.push_back(individual.tree);
      checkpoint.fitness.push_back(individual.fitness);
    }
    for (const FrontIndividual& member : archive_.members()) {
      checkpoint.archive.push_back(member.tree);
    }
    checkpoint.hall_of_fame = hall_;
    return checkpoint;
  }

  // What was kept, on a sample that none of it was chosen by.
  Result<Evolved> final_front() {
    std::vector<Tree> trees;
    for (const FrontIndividual& member : archive_.members()) {
      trees.push_back(member.tree);
    }
    auto members = measured(std::move(trees), kFinalGeneration);
    if (!members) {
      return best_so_far(members.error());
    }
    return answer(*members, false);
  }

  // After an interruption: what there is. Any other error goes to the caller.
  Result<Evolved> best_so_far(const Error& error) const {
    if (error.kind != ErrorKind::interrupted || hall_.empty()) {
      return tl::unexpected(error);
    }
    return answer(archive_.members(), true);
  }

  Evolved answer(const std::vector<FrontIndividual>& kept, bool interrupted) const {
    const std::vector<double> values = costs_of(kept);
    const std::vector<std::uint32_t> ranks = ranks_of({values, costs()});
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
    evolved.generations_done = done_;
    evolved.interrupted = interrupted;
    evolved.front.measures = measuring_.measures();
    for (const FrontIndividual* member : members) {
      evolved.front.members.push_back({member->tree, member->fitness, measuring_.values(member->tally)});
    }
    auto chosen = pick(evolved.front, rule_);
    evolved.pick_fits = chosen.has_value();
    if (members.empty()) {  // no tree was small enough for the front
      evolved.best = best_on_record(hall_);
      return evolved;
    }
    if (!chosen) {
      chosen = pick(evolved.front, PickRule{});
    }
    const FrontIndividual& best = *members[*chosen];
    evolved.best = {best.tree, done_ - 1, best.fitness, agreement_of(best.tally)};
    evolved.final_steps = interrupted ? 0 : best.tally.steps;
    return evolved;
  }

  const Chain& chain_;
  const EvolveConfig& config_;
  ScalarFitness fitness_;
  Measuring measuring_;
  PickRule rule_;
  Breeding breeding_;
  Meanings meanings_;
  Evaluator& evaluator_;
  const EvolveHooks& hooks_;
  std::vector<FrontIndividual> population_;
  FrontArchive archive_;
  HallOfFame hall_;
  std::uint32_t done_ = 0;  // generations
};

}  // namespace

Result<Evolved> search_front(const Chain& chain, const EvolveConfig& config, Evaluator& evaluator,
                             std::optional<Checkpoint> start, const EvolveHooks& hooks) {
  auto rule = parse_pick(config.front.pick);
  if (!rule) {
    return tl::unexpected(rule.error());
  }
  auto fitness = ScalarFitness::make(chain, config.fitness, config.front.objectives);
  if (!fitness) {
    return tl::unexpected(fitness.error());
  }
  auto measuring = Measuring::make(chain, fitness->objectives(), config.rollout.steps);
  if (!measuring) {
    return tl::unexpected(measuring.error());
  }
  return FrontSearch(chain, config, std::move(*fitness), std::move(*measuring), std::move(*rule), evaluator, hooks)
      .run(std::move(start));
}

}  // namespace coppice
