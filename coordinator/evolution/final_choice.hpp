// The last comparison of a run: its finalists meet on one sample that none of them was chosen by, and one of them is
// the answer. Of a scalar search they are the champions of all generations, of a front search what is on the front.
// Immutable.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/evolution/champion.hpp"
#include "common/evolution/config.hpp"
#include "common/evolution/deme.hpp"
#include "common/evolution/front_gauge.hpp"
#include "common/evolution/scalar_fitness.hpp"
#include "coordinator/evolution/evolve.hpp"
#include "coordinator/evolution/pick.hpp"

namespace coppice {

// Where a run ends.
struct Reached {
  std::uint32_t generations = 0;           // that were done
  const HallOfFame& hall_of_fame;          // their champions
  const std::vector<Individual>& archive;  // search front: what was kept, as it was measured on the way
};

class FinalChoice {
 public:
  // REQUIRES: check_config(). Errors: as make_score_table().
  static Result<FinalChoice> make(const Chain& chain, const EvolveConfig& config);

  std::vector<Tree> finalists(const Reached& reached) const;
  // Search front: the archives of all demes as one, what is dominated there gone, of at most front.members.
  std::vector<Individual> united_archive(std::span<const std::shared_ptr<const Deme>> demes) const;
  // Scalar, as on the way.
  double fitness_of(const Tally& tally) const { return fitness_.of(tally); }
  // What is asked about them.
  Job job() const;
  // REQUIRES: a tally for each of finalists(reached); at least one generation is done.
  Evolved answer(const Reached& reached, std::vector<Tally> tallies) const;
  // Where they could not meet: the best by what was measured on the way. REQUIRES: at least one generation is done.
  Evolved interrupted(const Reached& reached) const;

 private:
  FinalChoice(EvolveConfig config, ScalarFitness fitness) : config_(std::move(config)), fitness_(std::move(fitness)) {}
  Evolved of_front(const Reached& reached, std::vector<Individual> kept, bool interrupted) const;

  EvolveConfig config_;
  ScalarFitness fitness_;
  std::optional<FrontGauge> gauge_;  // search front
  PickRule rule_;                    // search front
};

}  // namespace coppice
