// What a tree does in every state of a chain, beside what the policy does: CSV (RFC 4180), a row a state, for
// spreadsheets and plots.
#pragma once

#include <ostream>

#include "common/chain/chain.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// Columns: the features, visits, policy_action, tree_action (empty where the tree selects none). Lines end in LF, as
// every tool on this platform writes them. REQUIRES: check_tree() for the chain's vocabulary.
void write_state_table(const Chain& chain, const Tree& tree, std::ostream& out);

}  // namespace coppice
