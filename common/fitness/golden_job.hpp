// One fixed job that every process can evaluate, to find out whether it computes what the others compute. Sampled walks
// are integer arithmetic and agree everywhere; what is solved (exact, discounted and long-run occupancies) depends on
// the compiler, on Eigen and on KLU, so two builds of one version may differ in a last bit, and then in a tally.
//
// The checksum covers a small chain made from a fixed seed, trees grown from it, their tallies under every method and
// acting policy, and the bits of the occupancies before they are rounded to tallies. Coordinator and workers compare it
// when they meet; who differs is refused. Thread-safe; computed once, in a few milliseconds.
#pragma once

#include <cstdint>

#include "common/simd.hpp"

namespace coppice {

// XXH3-64 of what the golden job gives here. Never 0, which stands for "not told".
std::uint64_t golden_checksum();

// The same computed now, with the vector instructions named. REQUIRES: `simd` is none, or best_simd().
std::uint64_t compute_golden_checksum(Simd simd);

}  // namespace coppice
