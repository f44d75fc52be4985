#include "coordinator/evolution/evolve.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <numeric>
#include <utility>

#include "common/evolution/deme_search.hpp"
#include "common/evolution/migration.hpp"
#include "coordinator/evolution/config_text.hpp"
#include "coordinator/evolution/deme_evolution.hpp"
#include "coordinator/evolution/final_choice.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

class Evolution {
 public:
  explicit Evolution(EvolutionParts parts)
      : chain_(parts.chain),
        config_(parts.config),
        choice_(std::move(parts.choice)),
        search_(std::move(parts.search)),
        evaluator_(parts.evaluator),
        hooks_(parts.hooks) {}

  Result<Evolved> run(std::optional<Checkpoint> start) {
    if (start) {
      if (auto ok = go_on_from(std::move(*start)); !ok) {
        return tl::unexpected(ok.error());
      }
    }
    while (done_ < config_.ga.generations) {
      if (auto ok = run_generation(); !ok) {
        return best_so_far(ok.error());
      }
    }
    const Deme deme = search_->deme();
    const Reached reached{done_, hall_, deme.archive};
    auto tallies = evaluate_some(evaluator_, choice_.finalists(reached), choice_.job());
    return tallies ? choice_.answer(reached, std::move(*tallies)) : best_so_far(tallies.error());
  }

 private:
  Result<void> go_on_from(Checkpoint start) {
    auto demes = measured_again(start, config_, Breeding(chain_.vocabulary(), config_.ga.shape()),
                                search_->job(start.generation), evaluator_);
    if (!demes) {
      return tl::unexpected(demes.error());
    }
    done_ = start.generation + 1;
    search_->take_up(0, std::move(demes->front()));
    hall_ = std::move(start.hall_of_fame);
    return {};
  }

  Result<void> run_generation() {
    const Clock::time_point begin = Clock::now();
    std::vector<Tree> trees = search_->breed();
    auto tallies = evaluator_.evaluate(trees, search_->job(done_));
    if (!tallies) {
      // What was done before is as good as ever, unless it rests on a lie.
      if (tallies.error().kind != ErrorKind::revoked) {
        if (auto told = tell(); !told) {
          return told;
        }
      }
      return tl::unexpected(std::move(tallies).error());
    }
    GenerationRecord record = search_->settle(std::move(trees), std::move(*tallies));
    record.meanings = hooks_.count_meanings ? search_->count_meanings() : 0;
    enter(record.best, hall_);
    ++done_;
    record.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    untold_.push_back(std::move(record));
    return done_ == config_.ga.generations || !hooks_.due || hooks_.due() ? tell() : Result<void>();
  }

  Result<void> tell() {
    if (untold_.empty() || !hooks_.generations_done) {
      return {};
    }
    const std::vector<GenerationRecord> told = std::exchange(untold_, {});
    return hooks_.generations_done(told, checkpoint());
  }

  Checkpoint checkpoint() const {
    Checkpoint checkpoint{.generation = done_ - 1, .population = {}, .fitness = {}, .hall_of_fame = hall_};
    Deme deme = search_->deme();
    for (Individual& individual : deme.population) {
      checkpoint.population.push_back(std::move(individual.tree));
      checkpoint.fitness.push_back(choice_.fitness_of(individual.tally));
    }
    for (Individual& member : deme.archive) {
      checkpoint.archive.push_back(std::move(member.tree));
    }
    return checkpoint;
  }

  // After an interruption: what there is. Any other error goes to the caller.
  Result<Evolved> best_so_far(const Error& error) const {
    if (error.kind != ErrorKind::interrupted || hall_.empty()) {
      return tl::unexpected(error);
    }
    const Deme deme = search_->deme();
    return choice_.interrupted({done_, hall_, deme.archive});
  }

  const Chain& chain_;
  const EvolveConfig& config_;
  FinalChoice choice_;
  std::unique_ptr<DemeSearch> search_;
  Evaluator& evaluator_;
  const EvolveHooks& hooks_;
  HallOfFame hall_;
  std::uint32_t done_ = 0;                // generations
  std::vector<GenerationRecord> untold_;  // the last of them
};

}  // namespace

bool SavePace::due() const {
  constexpr int kFactor = 50;
  constexpr std::chrono::seconds kMostUnsaved{1};
  return Clock::now() - ended_ >= std::min<Clock::duration>(kFactor * took_, kMostUnsaved);
}

Result<void> SavePace::save(const std::function<Result<void>()>& saving) {
  const Clock::time_point begin = Clock::now();
  auto saved = saving();
  ended_ = Clock::now();
  took_ = ended_ - begin;
  return saved;
}

Result<std::vector<Tally>> evaluate_some(Evaluator& evaluator, std::span<const Tree> trees, const Job& job) {
  return trees.empty() ? std::vector<Tally>() : evaluator.evaluate(trees, job);
}

Result<std::vector<Deme>> measured_again(Checkpoint& start, const EvolveConfig& config, const Breeding& breeding,
                                         const Job& job, Evaluator& evaluator) {
  if (auto ok = check_checkpoint(start, config, breeding); !ok) {
    return tl::unexpected(ok.error());
  }
  auto population = evaluate_some(evaluator, start.population, job);
  if (!population) {
    return tl::unexpected(population.error());
  }
  auto archive = evaluate_some(evaluator, start.archive, job);
  if (!archive) {
    return tl::unexpected(archive.error());
  }
  std::vector<Deme> demes;
  std::size_t kept = 0;  // of the archive
  for (std::uint32_t number = 0; number < config.ga.demes; ++number) {
    Deme deme{.generations = start.generation + 1, .population = {}, .archive = {}};
    const DemeShare share = share_of(config.ga, number);
    for (std::size_t slot = share.first; slot < share.first + share.size; ++slot) {
      deme.population.push_back({std::move(start.population[slot]), std::move((*population)[slot])});
    }
    const std::size_t its_own = config.ga.demes > 1 ? start.kept[number] : start.archive.size();
    for (const std::size_t end = kept + its_own; kept < end; ++kept) {
      deme.archive.push_back({std::move(start.archive[kept]), std::move((*archive)[kept])});
    }
    demes.push_back(std::move(deme));
  }
  return demes;
}

Result<void> check_checkpoint(const Checkpoint& start, const EvolveConfig& config, const Breeding& breeding) {
  const GaConfig& ga = config.ga;
  if (start.generation >= ga.generations || start.population.size() != ga.population ||
      start.fitness.size() != start.population.size() || start.hall_of_fame.empty()) {
    return bad_input(
        fmt::format("checkpoint of generation {} with {} individuals, {} fitness values and {} champions: expected a "
                    "generation below {}, {} individuals and fitness values, and a champion",
                    start.generation, start.population.size(), start.fitness.size(), start.hall_of_fame.size(),
                    ga.generations, ga.population));
  }
  const bool apart = ga.demes > 1;
  if (start.kept.size() != (apart ? ga.demes : 0) ||
      (apart && std::accumulate(start.kept.begin(), start.kept.end(), std::size_t{0}) != start.archive.size()) ||
      (apart && start.generation + 1 != epoch_end(ga, start.generation / epoch_length(ga)))) {
    return bad_input(
        fmt::format("checkpoint of generation {} with the archives of {} demes, {} trees in all: expected the "
                    "last generation of an epoch, and {} demes",
                    start.generation, start.kept.size(), start.archive.size(), apart ? ga.demes : 0));
  }
  const auto fits = [&](const Tree& tree) { return breeding.within_limits(tree); };
  if (!std::all_of(start.population.begin(), start.population.end(), fits) ||
      !std::all_of(start.archive.begin(), start.archive.end(), fits) ||
      !std::all_of(start.hall_of_fame.begin(), start.hall_of_fame.end(),
                   [&](const Champion& champion) { return fits(champion.tree); })) {
    return bad_input(fmt::format("checkpoint of generation {}: holds a tree outside the limits of the configuration",
                                 start.generation));
  }
  return {};
}

Result<Evolved> evolve(const Chain& chain, const EvolveConfig& config, Evaluator& evaluator,
                       std::optional<Checkpoint> start, const EvolveHooks& hooks) {
  if (auto ok = check_config(config, chain.vocabulary()); !ok) {
    return tl::unexpected(ok.error());
  }
  auto choice = FinalChoice::make(chain, config);
  if (!choice) {
    return tl::unexpected(choice.error());
  }
  auto search = DemeSearch::make(chain, config);
  if (!search) {
    return tl::unexpected(search.error());
  }
  if (config.ga.demes > 1 || hooks.whole) {
    return evolve_demes({chain, config, std::move(*choice), std::move(*search), evaluator, hooks}, std::move(start));
  }
  return Evolution({chain, config, std::move(*choice), std::move(*search), evaluator, hooks}).run(std::move(start));
}

}  // namespace coppice
