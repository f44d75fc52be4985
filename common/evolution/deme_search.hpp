// How a deme goes from generation to generation, whoever evaluates it: breed() says which trees a generation asks
// about, settle() takes what came back. One kind of search for each value of ga.search. Chance in generation g is a
// pure function // of (seed, g, deme), so a search that takes up a deme goes on as if it had never been put down.
// Belongs to one thread.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "common/evolution/champion.hpp"
#include "common/evolution/config.hpp"
#include "common/evolution/deme.hpp"

namespace coppice {

class DemeSearch {
 public:
  // Of the kind that config.ga.search names. `chain` and `config` outlive it. REQUIRES: check_search(). Errors: as
  // make_score_table().
  static Result<std::unique_ptr<DemeSearch>> make(const Chain& chain, const EvolveConfig& config);

  DemeSearch() = default;
  DemeSearch(const DemeSearch&) = delete;
  DemeSearch& operator=(const DemeSearch&) = delete;
  virtual ~DemeSearch() = default;

  // What is asked about the trees of a generation.
  virtual Job job(std::uint32_t generation) const = 0;

  // Goes on from there: deme `number` of the run, whatever this had before; Deme() begins with nothing. REQUIRES:
  // number < ga.demes; the deme came from a search of this configuration, or is as good: of its size, trees within the
  // limits, tallies as job(deme.generations - 1) gives them.
  virtual void take_up(std::uint32_t number, Deme deme) = 0;
  // Takes in whom another deme sent. REQUIRES: as for the deme; fewer than the deme has beside its elites.
  virtual void admit(const std::vector<Individual>& migrants) = 0;
  // The trees of the generation that comes next; deme() stays as it was. REQUIRES: settle() has had those of the
  // generation before.
  virtual std::vector<Tree> breed() = 0;
  // Selects among those before and these. The record has no `seconds`. REQUIRES: the trees that breed() gave, and one
  // tally for each.
  virtual GenerationRecord settle(std::vector<Tree> trees, std::vector<Tally> tallies) = 0;

  // Different action tables in the population.
  virtual std::uint32_t count_meanings() = 0;

  virtual Deme deme() const = 0;
  // Whom the deme sends to another at this point: at most ga.migrants, none where there is no other.
  virtual std::vector<Individual> emigrants() const = 0;
};

}  // namespace coppice
