#include "coordinator/evolution/front_search.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "common/check.hpp"
#include "common/fitness/meaning.hpp"
#include "coordinator/evolution/dominance.hpp"
#include "coordinator/evolution/population.hpp"
#include "coordinator/evolution/scalar_fitness.hpp"
#include "coordinator/evolution/selection.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMaxBirths = 6;      // of a child, until it means something new
constexpr double kWeighted = 0.5;  // probability that a parent is chosen by weights
constexpr double kUnmeasured = 1e300;

struct Individual {
  Tree tree{ActionId{0}};
  Meaning meaning;
  Tally tally;
  double fitness = 0.0;
  std::vector<double> costs;  // [front.objectives]
};

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

std::vector<double> costs_of(const std::vector<Individual>& individuals) {
  std::vector<double> costs;
  for (const Individual& individual : individuals) {
    costs.insert(costs.end(), individual.costs.begin(), individual.costs.end());
  }
  return costs;
}

// Weights that sum to 1, uniform among all such (the gaps between sorted uniform numbers).
std::vector<double> random_weights(Stream& stream, std::size_t count) {
  constexpr std::uint64_t kParts = 1U << 20U;
  std::vector<double> cuts = {0.0, 1.0};
  for (std::size_t i = 1; i < count; ++i) {
    cuts.push_back(static_cast<double>(stream.below(kParts)) / static_cast<double>(kParts));
  }
  std::sort(cuts.begin(), cuts.end());
  std::vector<double> weights(count);
  for (std::size_t i = 0; i < count; ++i) {
    weights[i] = cuts[i + 1] - cuts[i];
  }
  return weights;
}

// Individuals to choose parents from, with what choosing needs.
class Pool {
 public:
  Pool(const std::vector<Individual>& individuals, std::size_t costs) : individuals_(individuals) {
    const std::vector<double> values = costs_of(individuals);
    const Costs all{values, costs};
    ranks_ = ranks_of(all);
    crowding_ = crowding_of(all, ranks_);
    low_.assign(costs, std::numeric_limits<double>::max());
    high_.assign(costs, std::numeric_limits<double>::lowest());
    for (std::size_t i = 0; i < individuals.size(); ++i) {
      for (std::size_t c = 0; c < costs && ranks_[i] == 0; ++c) {
        low_[c] = std::min(low_[c], all.of(i)[c]);
        high_[c] = std::max(high_[c], all.of(i)[c]);
      }
    }
  }

  // NSGA-II's binary tournament: the lower rank, then the less crowded, then the first drawn.
  const Individual& by_crowding(Stream& stream) const {
    const std::size_t a = stream.below(individuals_.size());
    const std::size_t b = stream.below(individuals_.size());
    const bool second = ranks_[b] != ranks_[a] ? ranks_[b] < ranks_[a] : crowding_[b] > crowding_[a];
    return individuals_[second ? b : a];
  }

  // The smallest weighted sum of costs, each by its range on the front, among `size` drawn.
  const Individual& by_weights(Stream& stream, std::span<const double> weights, std::size_t size) const {
    std::size_t winner = stream.below(individuals_.size());
    double least = weighted(winner, weights);
    for (std::size_t i = 1; i < size; ++i) {
      const std::size_t rival = stream.below(individuals_.size());
      if (const double sum = weighted(rival, weights); sum < least) {
        winner = rival;
        least = sum;
      }
    }
    return individuals_[winner];
  }

 private:
  double weighted(std::size_t i, std::span<const double> weights) const {
    double sum = 0.0;
    for (std::size_t c = 0; c < weights.size(); ++c) {
      const double range = high_[c] - low_[c];
      sum += range > 0.0 ? weights[c] * (individuals_[i].costs[c] - low_[c]) / range : 0.0;
    }
    return sum;
  }

  const std::vector<Individual>& individuals_;
  std::vector<std::uint32_t> ranks_;
  std::vector<double> crowding_;
  std::vector<double> low_;   // [costs], on the front
  std::vector<double> high_;  // [costs]
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
    auto population = evaluate(std::move(start.population), kFrontGeneration);
    if (!population) {
      return tl::unexpected(population.error());
    }
    auto archive = evaluate(std::move(start.archive), kFrontGeneration);
    if (!archive) {
      return tl::unexpected(archive.error());
    }
    population_ = std::move(*population);
    archive_ = std::move(*archive);
    hall_ = std::move(start.hall_of_fame);
    done_ = start.generation + 1;
    return {};
  }

  Result<void> run_generation(std::uint32_t generation) {
    const Clock::time_point begin = Clock::now();
    const bool anew = generation % part_length() == 0 && generation / part_length() <= config_.front.restarts;
    std::vector<Tree> trees = anew ? begin_anew(generation) : breed(generation);
    const std::size_t evaluations = trees.size();
    auto children = evaluate(std::move(trees), kFrontGeneration);
    if (!children) {
      return tl::unexpected(children.error());
    }
    for (const Individual& child : *children) {
      keep(child);
    }
    thin_archive();
    std::move(children->begin(), children->end(), std::back_inserter(population_));
    if (!anew) {
      select_survivors();
    }
    done_ = generation + 1;
    GenerationRecord record = statistics_of(generation);
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
    for (std::size_t i = 0; i < std::min(archive_.size(), trees.size()) && in_last_part(generation); ++i) {
      trees[i] = archive_[i].tree;
    }
    return trees;
  }

  std::vector<Tree> breed(std::uint32_t generation) {
    const GaConfig& ga = config_.ga;
    Stream stream(config_.seed, Purpose::breeding, generation, 0);
    Known known;
    for (const Individual& individual : population_) {
      known.add(individual.meaning, individual.tree.size());
    }
    for (const Individual& member : archive_) {
      if (in_last_part(generation)) {
        known.add(member.meaning, member.tree.size());
      }
    }
    const std::size_t costs = config_.front.objectives.size();
    const Pool population(population_, costs);
    const Pool archive(archive_.empty() || !in_last_part(generation) ? population_ : archive_, costs);
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

  Tree make_child(Stream& stream, const Pool& population, const Pool& archive) const {
    const GaConfig& ga = config_.ga;
    const std::vector<double> weights = random_weights(stream, config_.front.objectives.size());
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

  Result<std::vector<Individual>> evaluate(std::vector<Tree> trees, std::uint32_t generation) {
    if (trees.empty()) {
      return std::vector<Individual>();
    }
    auto tallies = evaluator_.evaluate(trees, job_of(config_, fitness_.objectives(), generation));
    if (!tallies) {
      return tl::unexpected(tallies.error());
    }
    COPPICE_CHECK(tallies->size() == trees.size());
    std::vector<Individual> result;
    result.reserve(trees.size());
    for (std::size_t i = 0; i < trees.size(); ++i) {
      Individual individual{std::move(trees[i]), {}, std::move((*tallies)[i]), 0.0, {}};
      individual.meaning = meanings_.of(individual.tree);
      individual.fitness = fitness_.of(individual.tally);
      individual.costs = costs_of_tally(individual.tally);
      result.push_back(std::move(individual));
    }
    return result;
  }

  std::vector<double> costs_of_tally(const Tally& tally) const {
    if (tally.steps == 0) {
      return std::vector<double>(config_.front.objectives.size(), kUnmeasured);
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

  // On the front, if nothing there is as good in everything.
  void keep(const Individual& candidate) {
    if (candidate.tree.size() > config_.front.max_nodes || candidate.tally.steps == 0) {
      return;
    }
    for (const Individual& member : archive_) {
      if (member.costs == candidate.costs || dominates(member.costs, candidate.costs)) {
        return;
      }
    }
    archive_.erase(std::remove_if(archive_.begin(), archive_.end(),
                                  [&](const Individual& member) { return dominates(candidate.costs, member.costs); }),
                   archive_.end());
    archive_.push_back(candidate);
  }

  void thin_archive() {
    if (archive_.size() > config_.front.members) {
      keep_best(archive_, config_.front.members);
    }
  }

  void select_survivors() {
    // A first generation, too, may hold what means the same: it goes first, as long as enough is left.
    Known known;
    const auto first_repeated = std::stable_partition(
        population_.begin(), population_.end(),
        [&](const Individual& individual) { return known.add(individual.meaning, individual.tree.size()); });
    const auto unlike = static_cast<std::size_t>(first_repeated - population_.begin());
    population_.resize(std::max<std::size_t>(unlike, config_.ga.population));
    keep_best(population_, config_.ga.population);
  }

  // The best by rank and crowding, in the order in which they stood.
  void keep_best(std::vector<Individual>& individuals, std::size_t count) const {
    const std::vector<double> values = costs_of(individuals);
    std::vector<std::size_t> kept = survivors({values, config_.front.objectives.size()}, count);
    std::sort(kept.begin(), kept.end());
    std::vector<Individual> next;
    next.reserve(count);
    for (const std::size_t i : kept) {
      next.push_back(std::move(individuals[i]));
    }
    individuals = std::move(next);
  }

  GenerationRecord statistics_of(std::uint32_t generation) const {
    std::vector<Tree> trees;
    std::vector<double> fitness;
    GenerationRecord record;
    record.generation = generation;
    std::size_t measured = 0;
    for (const Individual& individual : population_) {
      trees.push_back(individual.tree);
      fitness.push_back(individual.fitness);
      record.mean_nodes += static_cast<double>(individual.tree.size());
      if (individual.tally.steps > 0) {
        ++measured;
        record.mean_fitness += individual.fitness;
        record.mean_agreement += agreement_of(individual.tally);
      }
    }
    const Individual& best = population_[ranking(trees, fitness).front()];
    record.best = {best.tree, generation, best.fitness, agreement_of(best.tally)};
    record.mean_nodes /= static_cast<double>(population_.size());
    record.mean_fitness /= static_cast<double>(std::max<std::size_t>(measured, 1));
    record.mean_agreement /= static_cast<double>(std::max<std::size_t>(measured, 1));
    record.distinct_trees = static_cast<std::uint32_t>(count_distinct(trees));
    return record;
  }

  Checkpoint checkpoint(std::uint32_t generation) const {
    Checkpoint checkpoint;
    checkpoint.generation = generation;
    for (const Individual& individual : population_) {
      checkpoint.population.push_back(individual.tree);
      checkpoint.fitness.push_back(individual.fitness);
    }
    for (const Individual& member : archive_) {
      checkpoint.archive.push_back(member.tree);
    }
    checkpoint.hall_of_fame = hall_;
    return checkpoint;
  }

  // What was kept, on a sample that none of it was chosen by.
  Result<Evolved> final_front() {
    std::vector<Tree> trees;
    for (const Individual& member : archive_) {
      trees.push_back(member.tree);
    }
    auto members = evaluate(std::move(trees), kFinalGeneration);
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
    return answer(archive_, true);
  }

  Evolved answer(const std::vector<Individual>& kept, bool interrupted) const {
    const std::vector<double> values = costs_of(kept);
    const std::vector<std::uint32_t> ranks = ranks_of({values, config_.front.objectives.size()});
    std::vector<const Individual*> members;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (ranks[i] == 0 && kept[i].tally.steps > 0) {
        members.push_back(&kept[i]);
      }
    }
    std::stable_sort(members.begin(), members.end(), [](const Individual* a, const Individual* b) {
      return a->tree.size() != b->tree.size() ? a->tree.size() < b->tree.size() : a->fitness > b->fitness;
    });
    Evolved evolved;
    evolved.generations_done = done_;
    evolved.interrupted = interrupted;
    evolved.front.measures = measuring_.measures();
    for (const Individual* member : members) {
      evolved.front.members.push_back({member->tree, member->fitness, measuring_.values(member->tally)});
    }
    if (members.empty()) {  // no tree was small enough for the front
      evolved.best = best_on_record(hall_);
      return evolved;
    }
    auto chosen = pick(evolved.front, rule_);
    if (!chosen) {
      chosen = pick(evolved.front, PickRule{});
    }
    const Individual& best = *members[*chosen];
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
  std::vector<Individual> population_;
  std::vector<Individual> archive_;
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
