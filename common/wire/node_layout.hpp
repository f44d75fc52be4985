// How the nodes of trees lie on the wire, for every payload that holds some; common/wire's own.
//
//   tree:  u16 nodes, each {node} in prefix order
//   node:  u8 kind + 4 x op, then composite: u16 extent; condition: u8 feature, u8 value; action: u8 action
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <span>
#include <type_traits>
#include <vector>

#include "common/chain/bytes.hpp"
#include "common/error.hpp"
#include "common/tree/tree.hpp"

namespace coppice::wire {

inline constexpr unsigned kOpShift = 2;

// Nodes are most of a task, and what kind comes next is a guess that a processor loses at every third: they are read
// and written without a branch on it, in words of four bytes of which two or three count.
inline constexpr std::size_t kWord = sizeof(std::uint32_t);

// How a node lies in the word that begins with a tag, and how in memory: kind, operator, index and value, then extent.
struct Layout {
  std::uint8_t bytes = 0;      // of the word; 0: no node begins with this tag
  std::uint32_t head = 0;      // kind and operator
  std::uint32_t operands = 0;  // mask: index and value
  std::uint16_t span = 0;      // mask: extent
  std::uint16_t extent = 0;    // where the word has none
};
inline constexpr std::size_t kTags = 8;
inline constexpr std::array<Layout, kTags> kLayouts = [] {
  std::array<Layout, kTags> layouts{};
  for (const unsigned kind : {0U, 1U}) {
    layouts[kind] = {3, kind, 0, 0xFFFF, 0};
  }
  for (const unsigned op : {0U, 1U}) {
    layouts[2U | op << kOpShift] = {3, 2U | op << 8U, 0xFFFF, 0, 1};
  }
  layouts[3] = {2, 3, 0xFF, 0, 1};
  return layouts;
}();
static_assert(sizeof(Node) == 6 && std::is_trivially_copyable_v<Node> && offsetof(Node, index) == 2 &&
              offsetof(Node, value) == 3 && offsetof(Node, extent) == 4);

inline Node node_of(std::uint32_t word, const Layout& layout) {
  const std::uint32_t rest = word >> 8U;
  const std::uint64_t head = layout.head | (rest & layout.operands) << 16U;
  const std::uint64_t whole = head | std::uint64_t{(rest & layout.span) | layout.extent} << 32U;
  std::array<std::uint8_t, sizeof(Node)> bytes;
  std::memcpy(bytes.data(), &whole, sizeof(Node));
  return std::bit_cast<Node>(bytes);
}

inline std::uint32_t word_of(const Node& node) {
  const auto tag = static_cast<unsigned>(node.kind) | static_cast<unsigned>(node.op) << kOpShift;
  const unsigned leaf = node.index | static_cast<unsigned>(node.value) << 8U;
  return tag | (node.is_composite() ? node.extent : leaf) << 8U;
}

inline bool is_node_tag(std::uint8_t tag) { return tag < kTags && kLayouts[tag].bytes != 0; }

inline void put_node(const Node& node, ByteWriter& writer) {
  const std::uint32_t word = word_of(node);
  for (std::size_t i = 0; i < kLayouts[word & 0xFFU].bytes; ++i) {
    writer.put(static_cast<std::uint8_t>(word >> 8U * i));
  }
}

// False: the tag is unknown; `node` then holds it as its value.
inline bool get_node(ByteReader& reader, Node& node) {
  const auto tag = reader.get<std::uint8_t>();
  if (!is_node_tag(tag)) {
    node.value = tag;
    return false;
  }
  std::uint32_t word = tag;
  for (std::size_t i = 1; i < kLayouts[tag].bytes; ++i) {
    word |= std::uint32_t{reader.get<std::uint8_t>()} << 8U * i;
  }
  node = node_of(word, kLayouts[tag]);
  return true;
}

inline tl::unexpected<Error> unknown_node(std::uint8_t tag) {
  return bad_input(fmt::format("node tag {} is unknown: expected 0 to 3, or 6", tag));
}

// Writes up to a word's rest past the end.
inline std::uint8_t* write_tree(const Tree& tree, std::uint8_t* at) {
  const auto count = static_cast<std::uint16_t>(tree.size());
  std::memcpy(at, &count, sizeof(count));
  at += sizeof(count);
  for (const Node& node : tree.nodes()) {
    const std::uint32_t word = word_of(node);
    std::memcpy(at, &word, sizeof(word));
    at += kLayouts[word & 0xFFU].bytes;
  }
  return at;
}

// What follows the last byte reads as 0. REQUIRES: at < bytes.size().
inline std::uint32_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint32_t word = 0;
  if (const std::size_t left = bytes.size() - at; left >= kWord) {
    std::memcpy(&word, bytes.data() + at, kWord);
  } else {
    std::memcpy(&word, bytes.data() + at, left);
  }
  return word;
}

// Reads one tree's nodes from the front of `bytes` into `nodes`, whose memory is used again, and takes them off;
// whether they are a tree is not asked. Errors: cut short, too many, an unknown node.
inline Result<void> read_nodes(std::span<const std::uint8_t>& bytes, std::vector<Node>& nodes) {
  ByteReader reader(bytes.first(std::min(bytes.size(), sizeof(std::uint16_t))));
  const auto count = reader.get<std::uint16_t>();
  if (!reader.ok()) {
    return bad_input("tree is cut short");
  }
  if (count > kMaxTreeNodes) {
    return bad_input(fmt::format("tree has {} nodes: expected at most {}", count, kMaxTreeNodes));
  }
  std::size_t at = sizeof(count);
  // A node takes two bytes at least.
  nodes.resize(std::min<std::size_t>(count, bytes.size() / 2));
  if (nodes.size() < count) {
    return bad_input("tree is cut short");
  }
  for (Node& node : nodes) {
    if (at == bytes.size()) {
      return bad_input("tree is cut short");
    }
    const std::uint32_t word = word_at(bytes, at);
    const auto tag = static_cast<std::uint8_t>(word);
    if (!is_node_tag(tag)) {
      return unknown_node(tag);
    }
    node = node_of(word, kLayouts[tag]);
    at += kLayouts[tag].bytes;
    if (at > bytes.size()) {
      return bad_input("tree is cut short");
    }
  }
  bytes = bytes.subspan(at);
  return {};
}

}  // namespace coppice::wire
