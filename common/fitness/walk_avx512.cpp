// walk.hpp with eight lanes to a vector. The functions carry their instruction set as an attribute, so that nothing
// else in the program is compiled for it.
#include "common/check.hpp"
#include "common/fitness/walk.hpp"

#if defined(__x86_64__)
#include <array>
#include <immintrin.h>

#define COPPICE_AVX512 __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl")))

namespace coppice {
namespace {

constexpr std::uint32_t kWidth = PreparedJob::kVectorLanes;

struct Constants {
  const PackedRow* rows;
  const PackedBin* bins;
  std::uint64_t reach;         // in the upper half
  std::uint64_t last_decided;  // largest place before a bin's end that decides, in the upper half
  std::uint64_t states;
};

// Vectors x kWidth lanes from `first` on.
template <std::uint32_t Vectors, bool kMixed, bool kPath>
COPPICE_AVX512 void walk_vectors(const Walk& walk, const Constants& constants, std::uint32_t first) {
  const std::uint32_t steps = walk.job.job().steps;
  const std::uint32_t stride = walk.job.lanes();
  const std::uint32_t* draws = walk.job.draws(walk.pass) + first;
  const std::uint8_t* policy_acts = kMixed ? walk.job.policy_acts(walk.pass) + first : nullptr;
  const __m512i low_16 = _mm512_set1_epi64(0xFFFF);
  const __m512i reach = _mm512_set1_epi64(static_cast<long long>(constants.reach));
  const __m512i last_decided = _mm512_set1_epi64(static_cast<long long>(constants.last_decided));
  const __m512i states = _mm512_set1_epi64(static_cast<long long>(constants.states));
  const std::uint32_t* starts = walk.job.starts(walk.pass) + first;
  __m512i base[Vectors];
  __m512i at[Vectors];
  __m512i matches[Vectors];
  for (std::uint32_t v = 0; v < Vectors; ++v) {
    base[v] = _mm512_cvtepu32_epi64(
        _mm256_loadu_si256(reinterpret_cast<const __m256i*>(walk.first_row + first + std::size_t{v} * kWidth)));
    const __m512i start =
        _mm512_cvtepu32_epi64(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(starts + std::size_t{v} * kWidth)));
    at[v] = _mm512_add_epi64(base[v], start);
    matches[v] = _mm512_setzero_si512();
  }
  for (std::uint32_t step = 0; step < steps; ++step) {
    const std::size_t line = std::size_t{step} * stride;
    for (std::uint32_t v = 0; v < Vectors; ++v) {
      const std::size_t here = line + std::size_t{v} * kWidth;
      const __m512i x = _mm512_cvtepu32_epi64(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(draws + here)));
      if constexpr (kPath) {
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(walk.path + first + here),
                            _mm512_cvtepi64_epi32(_mm512_sub_epi64(at[v], base[v])));
      }
      __m512i row_at = at[v];
      if constexpr (kMixed) {
        const __m512i acts =
            _mm512_cvtepu8_epi64(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(policy_acts + here)));
        row_at = _mm512_add_epi64(row_at, _mm512_mul_epu32(acts, states));
      }
      const __m512i row = _mm512_i64gather_epi64(row_at, constants.rows, 8);
      matches[v] = _mm512_add_epi64(matches[v], _mm512_srli_epi64(row, 63));
      const __m512i product = _mm512_mul_epu32(x, row);
      const __m512i begin = _mm512_srli_epi64(_mm512_slli_epi64(row, 1), 33);
      const __m512i bin =
          _mm512_i64gather_epi64(_mm512_add_epi64(begin, _mm512_srli_epi64(product, 32)), constants.bins, 8);
      const __m512i place = _mm512_slli_epi64(product, 32);
      // The low half of `bin` decides comparisons of equal upper halves only, which are not decided anyway.
      const __mmask8 own = _mm512_cmplt_epu64_mask(place, bin);
      const auto undecided = static_cast<__mmask8>(_mm512_cmplt_epu64_mask(_mm512_sub_epi64(bin, place), reach) |
                                                   _mm512_cmpgt_epu64_mask(place, last_decided));
      __m512i next = _mm512_and_si512(_mm512_mask_srli_epi64(bin, own, bin, 16), low_16);
      if (undecided != 0) [[unlikely]] {
        alignas(64) std::array<PackedRow, kWidth> row_of;
        alignas(64) std::array<std::uint64_t, kWidth> next_of;
        _mm512_store_si512(row_of.data(), row);
        _mm512_store_si512(next_of.data(), next);
        for (std::uint32_t lane = 0; lane < kWidth; ++lane) {
          if ((undecided >> lane & 1) != 0) {
            next_of[lane] = step_carefully(walk, first + v * kWidth + lane, step, row_of[lane]);
          }
        }
        next = _mm512_load_si512(next_of.data());
      }
      at[v] = _mm512_add_epi64(base[v], next);
    }
  }
  for (std::uint32_t v = 0; v < Vectors; ++v) {
    _mm512_storeu_si512(walk.matches + first + std::size_t{v} * kWidth, matches[v]);
  }
}

template <bool kMixed, bool kPath>
void walk_all(const Walk& walk) {
  const AliasRows& rows = walk.job.chain().rows();
  const std::uint64_t reach = rows.reach();
  const Constants constants{walk.rows, rows.bins().data(), reach << 32U, ((std::uint64_t{1} << 32U) - reach) << 32U,
                            walk.job.chain().chain().states()};
  std::uint32_t first = 0;
  for (; first + 4 * kWidth <= walk.lanes_used; first += 4 * kWidth) {
    walk_vectors<4, kMixed, kPath>(walk, constants, first);
  }
  switch ((walk.lanes_used - first + kWidth - 1) / kWidth) {
    case 4:
      walk_vectors<4, kMixed, kPath>(walk, constants, first);
      break;
    case 3:
      walk_vectors<3, kMixed, kPath>(walk, constants, first);
      break;
    case 2:
      walk_vectors<2, kMixed, kPath>(walk, constants, first);
      break;
    case 1:
      walk_vectors<1, kMixed, kPath>(walk, constants, first);
      break;
    default:
      break;
  }
}

}  // namespace

COPPICE_AVX512 void choose_rows_avx512(const RowChoice& choice, PackedRow* out) {
  const PackedRow* rows = choice.rows.rows().data();
  const std::size_t stride = choice.rows.stride();
  const __m512i flag = _mm512_set1_epi64(static_cast<long long>(kRowFlag));
  const __m512i next_states = _mm512_set1_epi64(static_cast<long long>(stride) * static_cast<long long>(kWidth));
  __m512i row_of_state =
      _mm512_mullo_epi64(_mm512_set_epi64(7, 6, 5, 4, 3, 2, 1, 0), _mm512_set1_epi64(static_cast<long long>(stride)));
  std::size_t s = 0;
  for (; s + kWidth <= choice.states; s += kWidth) {
    const __m128i acts = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(choice.acts + s));
    const __m128i actions = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(choice.actions + s));
    const __m128i policy = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(choice.policy + s));
    const auto matches = static_cast<__mmask8>(_mm_cmpeq_epi8_mask(actions, policy));
    const __m512i chosen = _mm512_i64gather_epi64(_mm512_add_epi64(row_of_state, _mm512_cvtepu8_epi64(acts)), rows, 8);
    _mm512_storeu_si512(out + s, _mm512_mask_or_epi64(chosen, matches, chosen, flag));
    row_of_state = _mm512_add_epi64(row_of_state, next_states);
  }
  for (; s < choice.states; ++s) {
    out[s] = rows[s * stride + choice.acts[s]] | (choice.actions[s] == choice.policy[s] ? kRowFlag : 0);
  }
}

void walk_avx512(const Walk& walk) {
  with_kind_of(walk, [&](auto mixed, auto path) { walk_all<mixed, path>(walk); });
}

}  // namespace coppice

#else

namespace coppice {

void choose_rows_avx512(const RowChoice&, PackedRow*) { COPPICE_CHECK(false); }
void walk_avx512(const Walk&) { COPPICE_CHECK(false); }

}  // namespace coppice

#endif
