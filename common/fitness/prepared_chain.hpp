// A chain made ready for evaluation. Made once per chain and process; immutable, shared by all threads.
//
// It has one of two forms. With tables, its rows are alias rows and a tree is evaluated on all states at once; a chain
// too large for that is walked lazily: trees are ticked in the states that walks reach, rows are sampled straight from
// the chain, and the chain costs no memory but its own. Both forms give the same tallies.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "common/chain/alias_rows.hpp"
#include "common/chain/chain.hpp"
#include "common/tree/state_columns.hpp"

namespace coppice {

class PreparedChain {
 public:
  enum class Form : std::uint8_t { tables, lazy };

  // Tables wherever AliasRows fit: up to 2^16 states a whole action table costs less than the ticks of a few hundred
  // steps (tests/bench/evaluation_bench).
  static std::shared_ptr<const PreparedChain> make(std::shared_ptr<const Chain> chain);
  // The given form, for tests and benchmarks. REQUIRES: lazy, or AliasRows::fits(*chain).
  static std::shared_ptr<const PreparedChain> make(std::shared_ptr<const Chain> chain, Form form);

  const Chain& chain() const { return *chain_; }
  Form form() const { return rows_ ? Form::tables : Form::lazy; }
  // REQUIRES: form() == Form::tables.
  const AliasRows& rows() const { return *rows_; }
  // Made when first asked for: a lazy chain needs them for objectives over all states only.
  const StateColumns& columns() const;
  // The policy's action index of every state. [states]
  const std::vector<std::uint8_t>& policy() const { return policy_; }

 private:
  PreparedChain(std::shared_ptr<const Chain> chain, Form form);

  std::shared_ptr<const Chain> chain_;
  std::vector<std::uint8_t> policy_;
  std::optional<AliasRows> rows_;
  mutable std::once_flag columns_made_;
  mutable std::optional<StateColumns> columns_;
};

}  // namespace coppice
