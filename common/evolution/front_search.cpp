#include "common/evolution/front_search.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <iterator>
#include <numeric>
#include <optional>
#include <unordered_set>
#include <utility>

#include "common/check.hpp"
#include "common/evolution/breeding.hpp"
#include "common/evolution/evaluated.hpp"
#include "common/evolution/front_gauge.hpp"
#include "common/evolution/front_individual.hpp"
#include "common/evolution/guided_climb.hpp"
#include "common/evolution/migration.hpp"
#include "common/evolution/population.hpp"
#include "common/evolution/scalar_fitness.hpp"
#include "common/fitness/meaning.hpp"

namespace coppice {
namespace {

constexpr int kMaxBirths = 6;       // of a child, until it means something new
constexpr double kWeighted = 0.5;   // probability that a parent is chosen by weights
constexpr double kAround = 0.5;     // probability that a climb begins towards random weights
constexpr double kPairs = 0.25;     // probability that a climb tries two edits at a time
constexpr double kExploring = 4e6;  // states that the beam may solve for, about
constexpr double kLeaping = 4e6;    // the same of the leaps of one climb
constexpr double kFewestEvaluations = 300;
constexpr double kMostEvaluations = 10'000;

// The smallest tree of each meaning that there is: a hash table without a node for each entry, since one is made for
// every generation.
class Known {
 public:
  // For so many meanings; more are taken in as well.
  explicit Known(std::size_t usual) : entries_(std::bit_ceil(2 * usual + 2)) {}

  // False: a tree that means the same and is no larger is there.
  bool add(const Meaning& meaning, std::size_t nodes) {
    if (2 * (size_ + 1) > entries_.size()) {
      grow();
    }
    Entry& entry = place_of(meaning);
    if (entry.nodes == 0) {
      ++size_;
    } else if (entry.nodes <= nodes) {
      return false;
    }
    entry = {meaning, nodes};
    return true;
  }

 private:
  struct Entry {
    Meaning meaning;
    std::size_t nodes = 0;  // 0: nobody's
  };

  Entry& place_of(const Meaning& meaning) {
    const std::size_t mask = entries_.size() - 1;
    std::size_t at = MeaningHash()(meaning) & mask;
    while (entries_[at].nodes != 0 && entries_[at].meaning != meaning) {
      at = (at + 1) & mask;
    }
    return entries_[at];
  }

  void grow() {
    const std::vector<Entry> before = std::exchange(entries_, std::vector<Entry>(2 * entries_.size()));
    for (const Entry& entry : before) {
      if (entry.nodes != 0) {
        place_of(entry.meaning) = entry;
      }
    }
  }

  std::vector<Entry> entries_;  // [a power of two], at most half of them somebody's
  std::size_t size_ = 0;
};

class FrontSearch : public DemeSearch {
 public:
  FrontSearch(const Chain& chain, const EvolveConfig& config, FrontGauge gauge, std::unique_ptr<GuidedClimb> guide)
      : chain_(chain),
        config_(config),
        gauge_(std::move(gauge)),
        guide_(std::move(guide)),
        breeding_(chain.vocabulary(), config.ga.shape()),
        meanings_(chain),
        individuals_(share_of(config.ga, 0).size) {}

  Job job(std::uint32_t) const override { return job_of(config_, gauge_.objectives(), kFrontGeneration); }

  void take_up(std::uint32_t number, Deme deme) override {
    number_ = number;
    individuals_ = share_of(config_.ga, number).size;
    generations_ = deme.generations;
    population_ = measured(std::move(deme.population));
    standing_.reset();
    archive_.assign(measured(std::move(deme.archive)));
  }

  std::vector<Tree> breed() override {
    bred_.clear();
    return begins_anew(generations_) ? begin_anew(generations_) : breed(generations_);
  }

  // Among the parents of the next generation; the archive may keep them.
  void admit(const std::vector<Individual>& migrants) override {
    for (const Individual& migrant : migrants) {
      population_.push_back(measured(migrant));
      keep(population_.back());
      standing_.reset();
    }
  }

  GenerationRecord settle(std::vector<Tree> trees, std::vector<Tally> tallies) override {
    COPPICE_CHECK(trees.size() == tallies.size());
    const std::uint32_t generation = generations_++;
    const std::size_t evaluations = trees.size();
    const std::vector<Meaning> meanings = std::exchange(bred_, {});
    if (begins_anew(generation)) {
      population_.clear();
    }
    standing_.reset();
    population_.reserve(population_.size() + trees.size());
    for (std::size_t i = 0; i < trees.size(); ++i) {
      population_.push_back(gauge_.of({std::move(trees[i]), std::move(tallies[i])}));
      population_.back().meaning = meanings.empty() ? meanings_.of(population_.back().tree) : meanings[i];
      keep(population_.back());
    }
    archive_.thin(costs(), config_.front.members);
    if (!begins_anew(generation)) {
      select_survivors();
    }
    GenerationRecord record = statistics_of(seen(population_), generation);
    record.evaluations = evaluations;
    return record;
  }

  std::uint32_t count_meanings() override {
    std::unordered_set<Meaning, MeaningHash> found;
    for (const FrontIndividual& individual : population_) {
      found.insert(individual.meaning);
    }
    return static_cast<std::uint32_t>(found.size());
  }

  Deme deme() const override {
    Deme deme{.generations = generations_, .population = {}, .archive = {}};
    for (const FrontIndividual& individual : population_) {
      deme.population.push_back({individual.tree, individual.tally});
    }
    for (const FrontIndividual& member : archive_.members()) {
      deme.archive.push_back({member.tree, member.tally});
    }
    return deme;
  }

  // A random sample of what is kept: what none other beats in all measures is good in some way.
  std::vector<Individual> emigrants() const override {
    std::vector<Individual> sent;
    if (config_.ga.demes == 1) {
      return sent;
    }
    const auto& kept = archive_.members();
    std::vector<std::size_t> left(kept.size());
    std::iota(left.begin(), left.end(), std::size_t{0});
    Stream stream(config_.seed, Purpose::migrating, generations_, number_);
    while (sent.size() < config_.ga.migrants && !left.empty()) {
      const std::size_t chosen = stream.below(left.size());
      sent.push_back({kept[left[chosen]].tree, kept[left[chosen]].tally});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(chosen));
    }
    return sent;
  }

 private:
  void keep(const FrontIndividual& individual) { archive_.offer(individual, config_.front.max_nodes); }

  // Generations between two beginnings.
  std::uint32_t part_length() const { return config_.ga.generations / (config_.front.restarts + 1); }
  bool in_last_part(std::uint32_t generation) const { return generation / part_length() >= config_.front.restarts; }
  bool begins_anew(std::uint32_t generation) const {
    return generation % part_length() == 0 && generation / part_length() <= config_.front.restarts;
  }

  // A first population; the last one has all that was kept.
  std::vector<Tree> begin_anew(std::uint32_t generation) {
    std::vector<Tree> trees = first_population(breeding_, config_, chain_, generation, number_);
    const std::vector<FrontIndividual>& kept = archive_.members();
    for (std::size_t i = 0; i < std::min(kept.size(), trees.size()) && in_last_part(generation); ++i) {
      trees[i] = kept[i].tree;
    }
    explore(trees);
    return trees;
  }

  // What a beam finds takes the place of up to half of the trees.
  void explore(std::vector<Tree>& trees) {
    if (guide_ == nullptr || number_ != 0) {
      return;
    }
    std::size_t slot = trees.size() / 2;
    for (Tree& found : guide_->explore(gauge_.worth(towards_first()), edit_limits(), evaluations_of(kExploring))) {
      if (slot < trees.size() && breeding_.within_limits(found)) {
        trees[slot] = std::move(found);
        ++slot;
      }
    }
  }

  // Halfway and at the end: from the best by the first of the objectives a climb that also leaps.
  void climb_from_best(Known& known, std::vector<Tree>& children) {
    const std::uint32_t after = generations_ + 1;
    const std::vector<FrontIndividual>& kept = archive_.members();
    if (guide_ == nullptr || number_ != 0 || kept.empty() ||
        (after != config_.ga.generations && after != config_.ga.generations / 2)) {
      return;
    }
    const auto best = std::min_element(kept.begin(), kept.end(),
                                       [](const auto& a, const auto& b) { return a.costs.front() < b.costs.front(); });
    Tree climbed = guide_->climb(best->tree, gauge_.worth(towards_first()), edit_limits(),
                                 {.steps = config_.ga.guided_steps, .pairs = true, .leaps = evaluations_of(kLeaping)});
    if (const Meaning reached = meanings_.of(climbed);
        breeding_.within_limits(climbed) && known.add(reached, climbed.size())) {
      children.back() = std::move(climbed);
      bred_.back() = reached;
    }
  }

  // [costs]
  std::vector<double> towards_first() const {
    std::vector<double> first(costs(), 0.0);
    first.front() = 1.0;
    return first;
  }

  // So many states may be solved for, whatever the chain's size.
  std::uint64_t evaluations_of(double states) const {
    return static_cast<std::uint64_t>(
        std::clamp(states / static_cast<double>(chain_.states()), kFewestEvaluations, kMostEvaluations));
  }

  std::vector<Tree> breed(std::uint32_t generation) {
    const GaConfig& ga = config_.ga;
    Stream stream(config_.seed, Purpose::breeding, generation, number_);
    Known known(population_.size() + archive_.members().size() + 2 * individuals_);
    for (const FrontIndividual& individual : population_) {
      known.add(individual.meaning, individual.tree.size());
    }
    for (const FrontIndividual& member : archive_.members()) {
      if (in_last_part(generation)) {
        known.add(member.meaning, member.tree.size());
      }
    }
    if (!standing_) {
      const std::vector<double> values = costs_of(population_);
      standing_ = standing_of({values, costs()});
    }
    const ParentPool population(population_, costs(), &*standing_);
    std::optional<ParentPool> archive;
    if (in_last_part(generation) && !archive_.members().empty()) {
      archive.emplace(archive_.members(), costs(), nullptr);
    }
    const Parents parents{population, archive ? *archive : population};
    std::vector<Tree> children;
    children.reserve(individuals_);
    while (children.size() < individuals_) {
      Tree child{ActionId{0}};
      Meaning meaning;
      for (int birth = 0; birth < kMaxBirths; ++birth) {
        child = make_child(stream, parents);
        if (ga.simplify == Simplification::lossless) {
          child = breeding_.simplified(child);
        }
        meaning = meanings_.of(child);
        if (known.add(meaning, child.size())) {
          climb(stream, population, known, child, meaning);
          break;
        }
      }
      children.push_back(std::move(child));
      bred_.push_back(meaning);
    }
    climb_from_best(known, children);
    return children;
  }

  // A share of the children climbs by guided edits, unless what comes of it is known already.
  void climb(Stream& stream, const ParentPool& population, Known& known, Tree& child, Meaning& meaning) {
    if (guide_ == nullptr || !stream.chance(config_.ga.guided)) {
      return;
    }
    GuidedClimb::Effort effort{.steps = config_.ga.guided_steps, .pairs = false};
    Tree climbed = child;
    if (stream.chance(kAround)) {
      std::vector<double> weights(costs());
      draw_weights(stream, weights);
      climbed = guide_->climb(climbed, gauge_.worth(population.by_range(weights)), edit_limits(), effort);
    }
    effort.pairs = stream.chance(kPairs);
    climbed = guide_->climb(climbed, gauge_.worth(population.by_range(towards_first())), edit_limits(), effort);
    if (!breeding_.within_limits(climbed)) {
      return;
    }
    if (const Meaning reached = meanings_.of(climbed); known.add(reached, climbed.size())) {
      child = std::move(climbed);
      meaning = reached;
    }
  }

  EditLimits edit_limits() const {
    const TreeShape shape = config_.ga.shape();
    return {.max_nodes = std::min<std::size_t>(shape.max_nodes, config_.front.max_nodes),
            .max_conditions = shape.max_conditions,
            .guarded = shape.guarded};
  }

  // Where parents come from.
  struct Parents {
    const ParentPool& population;
    const ParentPool& to_climb_from;
  };

  Tree make_child(Stream& stream, const Parents& parents) const {
    const GaConfig& ga = config_.ga;
    std::array<double, kMeasures> drawn;
    const std::span<double> weights = std::span(drawn).first(costs());
    draw_weights(stream, weights);
    const std::size_t size = tournament_size(ga, number_);
    if (stream.chance(ga.local_search)) {
      return breeding_.edit(stream, parents.to_climb_from.by_weights(stream, weights, size).tree);
    }
    const auto parent = [&]() -> const Tree& {
      return (stream.chance(kWeighted) ? parents.population.by_weights(stream, weights, size)
                                       : parents.population.by_crowding(stream))
          .tree;
    };
    const Tree& mother = parent();
    if (!stream.chance(ga.crossover)) {
      return mutated(stream, breeding_, ga, mother);
    }
    Tree child = breeding_.crossover_one(stream, mother, parent());
    return stream.chance(ga.mutation) ? mutated(stream, breeding_, ga, child) : child;
  }

  FrontIndividual measured(Individual individual) {
    FrontIndividual result = gauge_.of(std::move(individual));
    result.meaning = meanings_.of(result.tree);
    return result;
  }

  std::vector<FrontIndividual> measured(std::vector<Individual> individuals) {
    std::vector<FrontIndividual> result;
    result.reserve(individuals.size());
    for (Individual& individual : individuals) {
      result.push_back(measured(std::move(individual)));
    }
    return result;
  }

  static std::vector<Seen> seen(const std::vector<FrontIndividual>& individuals) {
    std::vector<Seen> result;
    result.reserve(individuals.size());
    for (const FrontIndividual& individual : individuals) {
      result.push_back({&individual.tree, &individual.tally, individual.fitness});
    }
    return result;
  }

  std::size_t costs() const { return config_.front.objectives.size(); }

  void select_survivors() {
    // A first generation, too, may hold what means the same: it goes first, as long as enough is left.
    Known known(population_.size());
    const auto first_repeated = std::stable_partition(
        population_.begin(), population_.end(),
        [&](const FrontIndividual& individual) { return known.add(individual.meaning, individual.tree.size()); });
    const auto unlike = static_cast<std::size_t>(first_repeated - population_.begin());
    population_.resize(std::max(unlike, individuals_));
    standing_ = keep_best(population_, costs(), individuals_);
  }

  const Chain& chain_;
  const EvolveConfig& config_;
  FrontGauge gauge_;
  std::unique_ptr<GuidedClimb> guide_;  // null: no child climbs
  Breeding breeding_;
  Meanings meanings_;
  std::vector<FrontIndividual> population_;
  std::optional<Standing> standing_;  // of the population, while it is known
  std::vector<Meaning> bred_;         // of the trees that breed() gave, if it had to know them
  FrontArchive archive_;
  std::uint32_t number_ = 0;
  std::size_t individuals_;  // of the deme
  std::uint32_t generations_ = 0;
};

}  // namespace

Result<std::unique_ptr<DemeSearch>> make_front_search(const Chain& chain, const EvolveConfig& config) {
  auto gauge = FrontGauge::make(chain, config);
  if (!gauge) {
    return tl::unexpected(gauge.error());
  }
  std::unique_ptr<GuidedClimb> guide;
  if (config.ga.guided > 0.0) {
    auto made = GuidedClimb::make(chain, job_of(config, gauge->objectives(), kFrontGeneration));
    if (!made) {
      return tl::unexpected(made.error());
    }
    guide = std::move(*made);
  }
  return std::unique_ptr<DemeSearch>(std::make_unique<FrontSearch>(chain, config, std::move(*gauge), std::move(guide)));
}

}  // namespace coppice
