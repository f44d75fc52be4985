// A chain made ready for evaluation: its states as bit columns and its rows as alias tables. Made once per chain and
// process; immutable, shared by all threads.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/chain/alias_rows.hpp"
#include "common/chain/chain.hpp"
#include "common/tree/state_columns.hpp"

namespace coppice {

class PreparedChain {
 public:
  // Errors: as AliasRows::make().
  static Result<std::shared_ptr<const PreparedChain>> make(std::shared_ptr<const Chain> chain);

  const Chain& chain() const { return *chain_; }
  const StateColumns& columns() const { return columns_; }
  const AliasRows& rows() const { return rows_; }
  // The policy's action index of every state. [states]
  const std::vector<std::uint8_t>& policy() const { return policy_; }

 private:
  PreparedChain(std::shared_ptr<const Chain> chain, AliasRows rows);

  std::shared_ptr<const Chain> chain_;
  StateColumns columns_;
  AliasRows rows_;
  std::vector<std::uint8_t> policy_;
};

}  // namespace coppice
