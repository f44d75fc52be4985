// What a counted log becomes: the arrays of a chain, and the problem beside them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/error.hpp"
#include "coordinator/exchange/log_passes.hpp"
#include "coordinator/exchange/problem_file.hpp"
#include "coordinator/problem/problem.hpp"

namespace coppice {

// Of the features, by their places: what the problem file wants, or nothing.
std::vector<FeatureWish> wishes_of(const SourceHeader& header, const ProblemFile& file);

// Vocabulary, features, transitions, rewards, collisions by reward, terminal states and starts. q, policy and visits
// are empty, the rows of terminal states too. Frees what the counter holds as it goes. Errors name the feature or the
// source; more transitions than a chain can have. REQUIRES: wishes = wishes_of().
Result<ChainParts> parts_of_log(CountedLog& log, const std::vector<FeatureWish>& wishes, const ProblemFile& file,
                                const std::string& source);

// Terminal states' rows: they stay, or lead to the starts. REQUIRES: those rows are empty.
void fill_ends(WhenTerminal terminal, ChainParts& parts);

// What happens where a tree chooses nothing. Errors: an action that is none of `actions` (as the source names them).
Result<NoAction> no_action_of(const ProblemFile& file, const std::vector<std::string>& actions);

// Labels and units. Errors: a label for what a feature does not read.
Result<Problem> problem_of_log(const CountedLog& log, const std::vector<FeatureWish>& wishes, const ProblemFile& file,
                               const Vocabulary& vocabulary, const std::optional<double>& discount);

}  // namespace coppice
