// Which vector instructions the evaluation kernels may use. Every kernel exists in portable C++ too, and both give the
// same bits (tests force either); the faster one is chosen when the program runs, so that one binary serves all hosts.
#pragma once

#include <cstdint>

namespace coppice {

enum class Simd : std::uint8_t {
  none,    // portable C++
  avx512,  // x86-64 with AVX-512 F, BW, DQ and VL (Intel since Skylake-SP, AMD since Zen 4)
};

inline Simd best_simd() {
#if defined(__x86_64__)
  static const bool has_avx512 = __builtin_cpu_supports("avx512f") > 0 && __builtin_cpu_supports("avx512bw") > 0 &&
                                 __builtin_cpu_supports("avx512dq") > 0 && __builtin_cpu_supports("avx512vl") > 0;
  return has_avx512 ? Simd::avx512 : Simd::none;
#else
  return Simd::none;
#endif
}

}  // namespace coppice
