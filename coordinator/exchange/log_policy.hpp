// The policy of a log, and what it is worth: what is done most in each state, one that is given, or the best by what
// was counted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "coordinator/exchange/import_source.hpp"
#include "coordinator/exchange/solve.hpp"

namespace coppice {

struct LogNames {
  const std::vector<std::string>& features;  // as the source calls them
  const std::vector<std::string>& actions;
};

// Fills q and policy of `parts`, and collisions where the problem file has a test for them; of the report value, ties,
// sweeps, bound, solved_on_one_try, distrusted and notes. Rows of terminal states are empty. tries: [states x actions].
// Errors: of solving and of the policy that is given; interrupted.
Result<void> value_log(const ImportSettings& settings, const ProblemFile& file, const LogNames& names,
                       const SolveSettings& solving, const std::vector<std::uint64_t>& tries,
                       const ImportProgress& go_on, ChainParts& parts, ImportReport& report);

}  // namespace coppice
