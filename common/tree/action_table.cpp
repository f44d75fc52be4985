#include "common/tree/action_table.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::size_t kWords = StateColumns::kBlockWords;
constexpr std::size_t kWordBits = 64;
constexpr std::size_t kMaxPlanes = 7;  // codes 0 (nothing written) to kMaxActions
static_assert((std::size_t{1} << kMaxPlanes) > kMaxActions);

// One bit for each of 512 states. The loops over it have a fixed length, so that the compiler unrolls them into
// vector instructions.
using Mask = std::array<std::uint64_t, kWords>;

bool is_empty(const Mask& mask) {
  std::uint64_t any = 0;
  for (std::size_t w = 0; w < kWords; ++w) {
    any |= mask[w];
  }
  return any == 0;
}

// A tree evaluated on one block of states. Plane p holds bit p of every state's blackboard, coded as action + 1.
class Block {
 public:
  Block(const Tree& tree, const StateColumns& columns, std::size_t planes, std::size_t first_word)
      : nodes_(tree.nodes().data()), columns_(columns), planes_(planes), first_word_(first_word) {
    for (std::size_t p = 0; p < planes_; ++p) {
      blackboard_[p] = Mask{};
    }
  }

  // Ticks node i in the states of `active`, which becomes the states in which it succeeded.
  void run(std::size_t i, Mask& active) {
    const Node& node = nodes_[i];
    switch (node.kind) {
      case NodeKind::condition:
        keep_where(node, active);
        break;
      case NodeKind::action:
        write(node, active);
        break;
      case NodeKind::sequence:
        run_sequence(i, active);
        break;
      case NodeKind::selector:
        run_selector(i, active);
        break;
    }
  }

  const std::array<Mask, kMaxPlanes>& blackboard() const { return blackboard_; }

 private:
  void keep_where(const Node& condition, Mask& active) const {
    const std::uint64_t* column = columns_.column(condition) + first_word_;
    for (std::size_t w = 0; w < kWords; ++w) {
      active[w] &= column[w];
    }
  }

  void write(const Node& action, const Mask& active) {
    const std::size_t code = std::size_t{action.index} + 1;
    for (std::size_t p = 0; p < planes_; ++p) {
      Mask& plane = blackboard_[p];
      if (((code >> p) & 1U) != 0) {
        for (std::size_t w = 0; w < kWords; ++w) {
          plane[w] |= active[w];
        }
      } else {
        for (std::size_t w = 0; w < kWords; ++w) {
          plane[w] &= ~active[w];
        }
      }
    }
  }

  void run_sequence(std::size_t i, Mask& active) {
    const std::size_t end = i + nodes_[i].extent;
    for (std::size_t child = i + 1; child < end; child += nodes_[child].extent) {
      run(child, active);
      if (is_empty(active)) {
        return;
      }
    }
  }

  void run_selector(std::size_t i, Mask& active) {
    const std::size_t end = i + nodes_[i].extent;
    Mask untried = active;
    for (std::size_t child = i + 1; child < end; child += nodes_[child].extent) {
      Mask succeeded = untried;
      run(child, succeeded);
      for (std::size_t w = 0; w < kWords; ++w) {
        untried[w] &= ~succeeded[w];
      }
      if (is_empty(untried)) {
        return;
      }
    }
    for (std::size_t w = 0; w < kWords; ++w) {
      active[w] &= ~untried[w];
    }
  }

  const Node* nodes_;
  const StateColumns& columns_;
  std::size_t planes_;
  std::size_t first_word_;
  std::array<Mask, kMaxPlanes> blackboard_;
};

// kSpread[b]: byte k is bit k of b.
constexpr std::array<std::uint64_t, 256> make_spread() {
  std::array<std::uint64_t, 256> spread{};
  for (std::size_t b = 0; b < spread.size(); ++b) {
    for (std::size_t k = 0; k < 8; ++k) {
      spread[b] |= static_cast<std::uint64_t>((b >> k) & 1U) << (8 * k);
    }
  }
  return spread;
}
constexpr std::array<std::uint64_t, 256> kSpread = make_spread();

constexpr std::uint64_t kHighBits = 0x8080808080808080U;
constexpr std::uint64_t kOnes = 0x0101010101010101U;

// Eight codes to eight results at once: code - 1, and `none` for code 0.
std::uint64_t results_of(std::uint64_t codes, std::uint64_t none) {
  const std::uint64_t actions = ((codes | kHighBits) - kOnes) ^ kHighBits;  // 0xFF for code 0
  return actions ^ (((actions >> 7U) & kOnes) * (none ^ 0xFFU));
}

void put_bytes(std::uint64_t bytes, std::uint8_t* out) {
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(out, &bytes, sizeof bytes);
  } else {
    for (std::size_t k = 0; k < sizeof bytes; ++k) {
      out[k] = static_cast<std::uint8_t>(bytes >> (8 * k));
    }
  }
}

// Writes the results of the 64 states of one word.
template <std::size_t kPlanes>
void expand_word(const std::array<Mask, kMaxPlanes>& blackboard, std::size_t word, std::uint64_t none,
                 std::uint8_t* out) {
  for (std::size_t shift = 0; shift < kWordBits; shift += 8) {
    std::uint64_t codes = 0;
    for (std::size_t p = 0; p < kPlanes; ++p) {
      codes |= kSpread[(blackboard[p][word] >> shift) & 0xFFU] << p;
    }
    put_bytes(results_of(codes, none), out + shift);
  }
}

// Writes the results of a block's first out.size() states.
template <std::size_t kPlanes>
void expand(const std::array<Mask, kMaxPlanes>& blackboard, std::uint64_t none, std::span<std::uint8_t> out) {
  for (std::size_t begin = 0; begin < out.size(); begin += kWordBits) {
    const std::size_t count = std::min(out.size() - begin, kWordBits);
    if (count == kWordBits) {
      expand_word<kPlanes>(blackboard, begin / kWordBits, none, out.data() + begin);
    } else {
      std::array<std::uint8_t, kWordBits> last;
      expand_word<kPlanes>(blackboard, begin / kWordBits, none, last.data());
      std::copy_n(last.begin(), count, out.begin() + static_cast<std::ptrdiff_t>(begin));
    }
  }
}

using Expand = void (*)(const std::array<Mask, kMaxPlanes>&, std::uint64_t, std::span<std::uint8_t>);
constexpr std::array<Expand, kMaxPlanes + 1> kExpandOf = {expand<0>, expand<1>, expand<2>, expand<3>,
                                                          expand<4>, expand<5>, expand<6>, expand<7>};

std::size_t planes_of(const Tree& tree) {
  std::size_t last_code = 0;
  for (const Node& node : tree.nodes()) {
    if (node.kind == NodeKind::action) {
      last_code = std::max(last_code, std::size_t{node.index} + 1);
    }
  }
  COPPICE_CHECK(last_code <= kMaxActions);
  return static_cast<std::size_t>(std::bit_width(last_code));
}

}  // namespace

void fill_action_table(const Tree& tree, const StateColumns& columns, std::uint8_t none,
                       std::span<std::uint8_t> actions) {
  COPPICE_CHECK(actions.size() == columns.states());
  const std::size_t planes = planes_of(tree);
  for (std::size_t word = 0; word < columns.words(); word += kWords) {
    Mask active;
    std::copy_n(columns.all() + word, kWords, active.begin());
    Block block(tree, columns, planes, word);
    block.run(0, active);
    const std::size_t first_state = word * kWordBits;
    kExpandOf[planes](block.blackboard(), none,
                      actions.subspan(first_state, std::min(actions.size() - first_state, kWords * kWordBits)));
  }
}

std::vector<ActionId> action_table(const Tree& tree, const StateColumns& columns) {
  std::vector<std::uint8_t> bytes(columns.states());
  fill_action_table(tree, columns, static_cast<std::uint8_t>(kNoAction), bytes);
  std::vector<ActionId> actions(bytes.size());
  std::transform(bytes.begin(), bytes.end(), actions.begin(), [](std::uint8_t byte) { return ActionId{byte}; });
  return actions;
}

}  // namespace coppice
