#include "common/fitness/meaning.hpp"

#include <xxhash.h>

#include "common/chain/alias_rows.hpp"
#include "common/tree/action_table.hpp"

namespace coppice {

Meaning meaning_of(std::span<const std::uint8_t> action_table) {
  const XXH128_hash_t hash = XXH3_128bits(action_table.data(), action_table.size());
  return {hash.low64, hash.high64};
}

Meaning meaning_of(const Tree& tree) {
  // Field by field: padding bytes are no part of a tree.
  std::vector<std::uint8_t> bytes;
  bytes.reserve(tree.size() * 8);
  for (const Node& node : tree.nodes()) {
    bytes.insert(bytes.end(), {static_cast<std::uint8_t>(node.kind), static_cast<std::uint8_t>(node.op), node.value,
                               static_cast<std::uint8_t>(node.index), static_cast<std::uint8_t>(node.index >> 8U),
                               static_cast<std::uint8_t>(node.extent), static_cast<std::uint8_t>(node.extent >> 8U)});
  }
  return meaning_of(bytes);
}

Meanings::Meanings(const Chain& chain) {
  if (AliasRows::fits(chain)) {
    columns_.emplace(chain.vocabulary(), chain.parts().features);
    actions_.resize(chain.states());
  }
}

Meaning Meanings::of(const Tree& tree) {
  if (!columns_) {
    return meaning_of(tree);
  }
  constexpr std::uint8_t kNone = 0xFF;
  fill_action_table(tree, *columns_, kNone, actions_);
  return meaning_of(actions_);
}

}  // namespace coppice
