// What a tree means on a chain, as a key: trees with the same action table have the same tally but for their nodes,
// because all individuals of a generation share their random numbers (design 3.3). Immutable values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/chain/chain.hpp"
#include "common/tree/state_columns.hpp"
#include "common/tree/tree.hpp"

namespace coppice {

// XXH3-128: two of 2^40 different tables share a key with a probability of about 2^-49.
struct Meaning {
  std::uint64_t low = 0;
  std::uint64_t high = 0;
  bool operator==(const Meaning&) const = default;
};

struct MeaningHash {
  std::size_t operator()(const Meaning& meaning) const { return static_cast<std::size_t>(meaning.low); }
};

// By the action table. [states]
Meaning meaning_of(std::span<const std::uint8_t> action_table);
// By the nodes alone, where no action table is made: equal trees, not equal meanings.
Meaning meaning_of(const Tree& tree);

// The meanings of trees that are not evaluated here. Scratch memory of one thread.
class Meanings {
 public:
  // By action tables wherever PreparedChain has tables.
  explicit Meanings(const Chain& chain);

  // REQUIRES: check_tree(tree, vocabulary of the chain).
  Meaning of(const Tree& tree);

 private:
  std::optional<StateColumns> columns_;
  std::vector<std::uint8_t> actions_;  // [states]
};

}  // namespace coppice
