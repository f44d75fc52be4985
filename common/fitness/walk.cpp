#include "common/fitness/walk.hpp"

#include <array>

namespace coppice {
namespace {

// Walks lanes first .. first + Lanes - 1.
template <std::uint32_t Lanes, bool kMixed, bool kPath>
void walk_lanes(const Walk& walk, std::uint32_t first) {
  const std::uint32_t steps = walk.job.job().steps;
  const std::uint32_t stride = walk.job.lanes();
  const AliasRows& rows = walk.job.chain().rows();
  const PackedBin* bins = rows.bins().data();
  const std::uint32_t reach = rows.reach();
  const auto states = static_cast<std::uint32_t>(walk.job.chain().chain().states());
  const std::uint32_t* draws = walk.job.draws(walk.pass) + first;
  const std::uint8_t* policy_acts = kMixed ? walk.job.policy_acts(walk.pass) + first : nullptr;
  std::array<const PackedRow*, Lanes> table;
  std::array<std::uint32_t, Lanes> state;
  std::array<std::uint64_t, Lanes> matches{};
  for (std::uint32_t lane = 0; lane < Lanes; ++lane) {
    table[lane] = walk.rows + walk.first_row[first + lane];
    state[lane] = walk.job.starts(walk.pass)[first + lane];
  }
  for (std::uint32_t step = 0; step < steps; ++step) {
    const std::size_t at = std::size_t{step} * stride;
    for (std::uint32_t lane = 0; lane < Lanes; ++lane) {
      const std::uint32_t here = state[lane];
      if constexpr (kPath) {
        walk.path[at + first + lane] = here;
      }
      const PackedRow row = kMixed ? table[lane][here + policy_acts[at + lane] * states] : table[lane][here];
      matches[lane] += row >> 63U;
      const AliasPlace place = place_of(draws[at + lane], bins_of(row));
      const PackedBin bin = bins[begin_of(row) + place.bin];
      const auto cutoff = static_cast<std::uint32_t>(bin >> 32U);
      state[lane] = static_cast<std::uint32_t>(place.within < cutoff ? bin >> 16U : bin) & 0xFFFFU;
      if (!is_decided(place.within, cutoff, reach)) [[unlikely]] {
        state[lane] = step_carefully(walk, first + lane, step, row);
      }
    }
  }
  for (std::uint32_t lane = 0; lane < Lanes; ++lane) {
    walk.matches[first + lane] = matches[lane];
  }
}

template <bool kMixed, bool kPath>
void walk_all(const Walk& walk) {
  constexpr std::uint32_t kSideBySide = 8;
  std::uint32_t first = 0;
  for (; first + kSideBySide <= walk.lanes_used; first += kSideBySide) {
    walk_lanes<kSideBySide, kMixed, kPath>(walk, first);
  }
  const std::uint32_t rest = walk.lanes_used - first;
  if ((rest & 4U) != 0) {
    walk_lanes<4, kMixed, kPath>(walk, first);
    first += 4;
  }
  if ((rest & 2U) != 0) {
    walk_lanes<2, kMixed, kPath>(walk, first);
    first += 2;
  }
  if (first < walk.lanes_used) {
    walk_lanes<1, kMixed, kPath>(walk, first);
  }
}

}  // namespace

std::uint32_t step_carefully(const Walk& walk, std::uint32_t lane, std::uint32_t step, PackedRow row) {
  const PreparedJob& job = walk.job;
  const std::uint32_t x = job.draws(walk.pass)[std::size_t{step} * job.lanes() + lane];
  return job.chain().rows().sample_carefully(row, x, [&](std::uint32_t attempt) {
    return more_bits(job.job(), job.rollout_of(walk.pass, lane), step, attempt);
  });
}

void choose_rows(const RowChoice& choice, PackedRow* out, Simd simd) {
  if (simd == Simd::avx512) {
    choose_rows_avx512(choice, out);
    return;
  }
  const PackedRow* rows = choice.rows.rows().data();
  const std::size_t stride = choice.rows.stride();
  for (std::size_t s = 0; s < choice.states; ++s) {
    out[s] = rows[s * stride + choice.acts[s]] | (choice.actions[s] == choice.policy[s] ? kRowFlag : 0);
  }
}

void walk(const Walk& walk, Simd simd) {
  if (simd == Simd::avx512) {
    walk_avx512(walk);
    return;
  }
  with_kind_of(walk, [&](auto mixed, auto path) { walk_all<mixed, path>(walk); });
}

}  // namespace coppice
