#include "common/fitness/meaning.hpp"

#include <vector>
#include <xxhash.h>

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

}  // namespace coppice
