#include "common/tree/action_table.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "common/check.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace coppice {
namespace {

constexpr std::size_t kBlockWords = StateColumns::kBlockWords;
constexpr std::size_t kMaxBlocks = 4;  // evaluated at once: a node is decoded once for all of them
constexpr std::size_t kWordBits = 64;
constexpr std::size_t kMaxPlanes = 8;  // codes 0 (nothing written) to kMaxActions
static_assert((std::size_t{1} << kMaxPlanes) > kMaxActions);

#define COPPICE_INLINE [[gnu::always_inline]] inline

// One bit for each of kWords x 64 states. The loops over it have a fixed length, so that the compiler unrolls them into
// vector instructions.
template <std::size_t kWords>
using Mask = std::array<std::uint64_t, kWords>;

template <std::size_t kWords>
COPPICE_INLINE bool is_empty(const Mask<kWords>& mask) {
  std::uint64_t any = 0;
  for (std::size_t w = 0; w < kWords; ++w) {
    any |= mask[w];
  }
  return any == 0;
}

// Plane p holds bit p of every state's blackboard, coded as action + 1; 0 where nothing was written.
template <std::size_t kWords>
using Planes = std::array<Mask<kWords>, kMaxPlanes>;

template <std::size_t kWords>
COPPICE_INLINE void write_action(std::size_t code, const Mask<kWords>& active, std::size_t planes,
                                 Planes<kWords>& blackboard) {
  for (std::size_t p = 0; p < planes; ++p) {
    Mask<kWords>& plane = blackboard[p];
    const std::uint64_t bit = 0 - ((code >> p) & 1U);
    for (std::size_t w = 0; w < kWords; ++w) {
      plane[w] = (plane[w] & ~active[w]) | (active[w] & bit);
    }
  }
}

// A composite whose children are being ticked.
template <std::size_t kWords>
struct Frame {
  std::size_t end;
  bool is_selector;
  Mask<kWords> entered;  // selector: the states that it was ticked in
  Mask<kWords> untried;  // selector: those of them in which no child succeeded yet
};

// Ticks a tree in the states of `active`, one bit each. Without recursion, so that all of it is compiled into its
// caller, for its caller's instruction set.
template <std::size_t kWords>
COPPICE_INLINE void run_words(const Tree& tree, const StateColumns& columns, std::size_t first_word,
                              Mask<kWords> active, std::size_t planes, Planes<kWords>& blackboard) {
  const Node* nodes = tree.nodes().data();
  std::array<Frame<kWords>, kMaxTreeDepth + 1> frames;
  std::size_t depth = 0;
  std::size_t i = 0;
  for (;;) {
    // Down: `active` are the states in which node i is ticked.
    const Node node = nodes[i];
    if (node.is_composite()) {
      Frame<kWords>& frame = frames[depth++];
      frame.end = i + node.extent;
      frame.is_selector = node.kind == NodeKind::selector;
      if (frame.is_selector) {
        frame.entered = active;
        frame.untried = active;
      }
      ++i;
      continue;
    }
    if (node.kind == NodeKind::condition) {
      const std::uint64_t* column = columns.column(node) + first_word;
      for (std::size_t w = 0; w < kWords; ++w) {
        active[w] &= column[w];
      }
    } else {
      write_action(std::size_t{node.index} + 1, active, planes, blackboard);
    }
    ++i;
    // Up: `active` are the states in which the node before i succeeded.
    for (;; --depth) {
      if (depth == 0) {
        return;
      }
      Frame<kWords>& frame = frames[depth - 1];
      if (frame.is_selector) {
        for (std::size_t w = 0; w < kWords; ++w) {
          frame.untried[w] &= ~active[w];
        }
        active = frame.untried;
      }
      if (i < frame.end && !is_empty(active)) {
        break;  // the next child is ticked where it may still matter
      }
      i = frame.end;
      if (frame.is_selector) {
        for (std::size_t w = 0; w < kWords; ++w) {
          active[w] = frame.entered[w] & ~frame.untried[w];
        }
      }
    }
  }
}

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
template <bool kHighCodes>
COPPICE_INLINE std::uint64_t results_of(std::uint64_t codes, std::uint64_t none) {
  if constexpr (kHighCodes) {  // some code has bit 7
    const std::uint64_t actions = ((codes | kHighBits) - kOnes) ^ (~codes & kHighBits);
    const std::uint64_t zero = ~(((codes & ~kHighBits) + ~kHighBits) | codes) & kHighBits;
    return actions ^ ((zero >> 7U) * (none ^ 0xFFU));
  }
  const std::uint64_t actions = ((codes | kHighBits) - kOnes) ^ kHighBits;  // 0xFF for code 0
  return actions ^ (((actions >> 7U) & kOnes) * (none ^ 0xFFU));
}

COPPICE_INLINE void put_bytes(std::uint64_t bytes, std::uint8_t* out) {
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(out, &bytes, sizeof bytes);
  } else {
    for (std::size_t k = 0; k < sizeof bytes; ++k) {
      out[k] = static_cast<std::uint8_t>(bytes >> (8 * k));
    }
  }
}

// Writes the results of the 64 states of one word.
template <std::size_t kPlanes, std::size_t kWords>
COPPICE_INLINE void expand_word(const Planes<kWords>& blackboard, std::size_t word, std::uint64_t none,
                                std::uint8_t* out) {
  for (std::size_t shift = 0; shift < kWordBits; shift += 8) {
    std::uint64_t codes = 0;
    for (std::size_t p = 0; p < kPlanes; ++p) {
      codes |= kSpread[(blackboard[p][word] >> shift) & 0xFFU] << p;
    }
    put_bytes(results_of<(kPlanes == kMaxPlanes)>(codes, none), out + shift);
  }
}

// Writes the results of a block's first out.size() states.
template <std::size_t kPlanes, std::size_t kWords>
void expand(const Planes<kWords>& blackboard, std::uint64_t none, std::span<std::uint8_t> out) {
  for (std::size_t begin = 0; begin < out.size(); begin += kWordBits) {
    const std::size_t count = std::min(out.size() - begin, kWordBits);
    if (count == kWordBits) {
      expand_word<kPlanes, kWords>(blackboard, begin / kWordBits, none, out.data() + begin);
    } else {
      std::array<std::uint8_t, kWordBits> last;
      expand_word<kPlanes, kWords>(blackboard, begin / kWordBits, none, last.data());
      std::copy_n(last.begin(), count, out.begin() + static_cast<std::ptrdiff_t>(begin));
    }
  }
}

template <std::size_t kWords>
void expand_portable(const Planes<kWords>& blackboard, std::size_t planes, std::uint8_t none,
                     std::span<std::uint8_t> out) {
  using Expand = void (*)(const Planes<kWords>&, std::uint64_t, std::span<std::uint8_t>);
  constexpr std::array<Expand, kMaxPlanes + 1> kExpandOf = {expand<0, kWords>, expand<1, kWords>, expand<2, kWords>,
                                                            expand<3, kWords>, expand<4, kWords>, expand<5, kWords>,
                                                            expand<6, kWords>, expand<7, kWords>, expand<8, kWords>};
  kExpandOf[planes](blackboard, none, out);
}

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

// Evaluates `tree` on kBlocks blocks from word `word` on and gives the blackboard to `expand` with the blocks' states.
template <std::size_t kBlocks, typename Expand>
COPPICE_INLINE void fill_blocks(const Tree& tree, const StateColumns& columns, std::size_t planes, std::size_t word,
                                std::span<std::uint8_t> actions, const Expand& expand) {
  constexpr std::size_t kWords = kBlocks * kBlockWords;
  Mask<kWords> active;
  std::copy_n(columns.all() + word, kWords, active.begin());
  Planes<kWords> blackboard;
  for (std::size_t p = 0; p < planes; ++p) {
    blackboard[p].fill(0);
  }
  run_words<kWords>(tree, columns, word, active, planes, blackboard);
  const std::size_t first_state = word * kWordBits;
  expand(blackboard, planes, actions.subspan(first_state, std::min(actions.size() - first_state, kWords * kWordBits)));
}

template <typename Expand>
COPPICE_INLINE void fill(const Tree& tree, const StateColumns& columns, std::span<std::uint8_t> actions,
                         const Expand& expand) {
  const std::size_t planes = planes_of(tree);
  std::size_t word = 0;
  for (; word + kMaxBlocks * kBlockWords <= columns.words(); word += kMaxBlocks * kBlockWords) {
    fill_blocks<kMaxBlocks>(tree, columns, planes, word, actions, expand);
  }
  switch ((columns.words() - word) / kBlockWords) {
    case 3:
      fill_blocks<3>(tree, columns, planes, word, actions, expand);
      break;
    case 2:
      fill_blocks<2>(tree, columns, planes, word, actions, expand);
      break;
    case 1:
      fill_blocks<1>(tree, columns, planes, word, actions, expand);
      break;
    default:
      break;
  }
}

void fill_portable(const Tree& tree, const StateColumns& columns, std::uint8_t none, std::span<std::uint8_t> actions) {
  fill(tree, columns, actions, [none](const auto& blackboard, std::size_t planes, std::span<std::uint8_t> out) {
    expand_portable(blackboard, planes, none, out);
  });
}

#if defined(__x86_64__)
#define COPPICE_AVX512 [[gnu::target("avx512f,avx512bw,avx512dq,avx512vl,prefer-vector-width=512")]]

// Sixty-four states' bytes at once, each bit of the blackboard added where its plane has it.
template <std::size_t kWords>
COPPICE_AVX512 void expand_avx512(const Planes<kWords>& blackboard, std::size_t planes, std::uint8_t none,
                                  std::span<std::uint8_t> out) {
  for (std::size_t begin = 0; begin < out.size(); begin += kWordBits) {
    __m512i codes = _mm512_setzero_si512();
    __mmask64 written = 0;
    for (std::size_t p = 0; p < planes; ++p) {
      const __mmask64 plane = blackboard[p][begin / kWordBits];
      written |= plane;
      codes = _mm512_mask_add_epi8(codes, plane, codes, _mm512_set1_epi8(static_cast<char>(1U << p)));
    }
    const __m512i results =
        _mm512_mask_sub_epi8(_mm512_set1_epi8(static_cast<char>(none)), written, codes, _mm512_set1_epi8(1));
    const std::size_t count = std::min(out.size() - begin, kWordBits);
    const __mmask64 states = count == kWordBits ? ~__mmask64{0} : (__mmask64{1} << count) - 1;
    _mm512_mask_storeu_epi8(out.data() + begin, states, results);
  }
}

COPPICE_AVX512 void fill_avx512(const Tree& tree, const StateColumns& columns, std::uint8_t none,
                                std::span<std::uint8_t> actions) {
  fill(tree, columns, actions, [none](const auto& blackboard, std::size_t planes, std::span<std::uint8_t> out) {
    expand_avx512(blackboard, planes, none, out);
  });
}
#else
void fill_avx512(const Tree&, const StateColumns&, std::uint8_t, std::span<std::uint8_t>) { COPPICE_CHECK(false); }
#endif

}  // namespace

void fill_action_table(const Tree& tree, const StateColumns& columns, std::uint8_t none,
                       std::span<std::uint8_t> actions, Simd simd) {
  COPPICE_CHECK(actions.size() == columns.states());
  if (simd == Simd::avx512) {
    fill_avx512(tree, columns, none, actions);
  } else {
    fill_portable(tree, columns, none, actions);
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
