// The canonical bytes of a chain, in the study file and on the wire, and the hash that names it. Equal chains have
// equal bytes, so the hash is the chain's identity: a worker keeps chains by it and a study detects damage by it.
// It is XXH3-128: it guards against faults, not against forgery (that is DDS Security's part).
//
// Layout, little-endian: "CPCH", u32 format; u16 features, each {text name, u8 operators, u16 values, u8 x values};
// u16 actions, each {text name}; u64 states, u64 transitions, u32 initial state; then the arrays of ChainParts in
// the order of their declaration, to visits. Downside: no compression.
//
// Format 1 is that. A chain that needs more has format 2, with these additions: behind a feature's values u8 scale and
// u16 numbers x f64; behind the initial state u32 starts x {u32 state, u32 count}, u8 no action, u8 its action, u8 look
// alikes, u32 terminals x u32, u8 has forbidden, u8 has collisions; behind the visits those two arrays, if there. A
// chain has one format only, so that equal chains have equal bytes and old ones keep their hash.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/chain/chain.hpp"

namespace coppice {

std::vector<std::uint8_t> to_bytes(const Chain& chain);

// Errors say what is wrong and where; every size is held against the bytes at hand before memory is taken, and the
// result passed Chain::make(). Never throws on any input.
Result<Chain> chain_from_bytes(std::span<const std::uint8_t> bytes);
// The same from consecutive pieces, each freed once it was read: the bytes and the chain never stand side by side.
Result<Chain> chain_from_pieces(std::vector<std::vector<std::uint8_t>> pieces);

struct ChainHash {
  std::array<std::uint8_t, 16> bytes{};
  std::string hex() const;
  auto operator<=>(const ChainHash&) const = default;
};

// XXH3-128 in its canonical (big-endian) order.
ChainHash hash_of(std::span<const std::uint8_t> bytes);
ChainHash hash_of(const std::vector<std::vector<std::uint8_t>>& pieces);
// Errors: not 32 hexadecimal digits.
Result<ChainHash> chain_hash_from_hex(std::string_view hex);

}  // namespace coppice
