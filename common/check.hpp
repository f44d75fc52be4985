// COPPICE_CHECK(condition): a broken invariant is a bug, and a bug stops the program in release builds too:
// a wrong fitness that goes on is worse than no fitness.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace coppice::detail {

[[noreturn]] inline void check_failed(const char* condition, const char* file, int line) {
  static_cast<void>(std::fprintf(stderr, "coppice: internal error: %s does not hold (%s:%d)\n", condition, file, line));
  std::abort();
}

}  // namespace coppice::detail

#define COPPICE_CHECK(condition) \
  ((condition) ? static_cast<void>(0) : ::coppice::detail::check_failed(#condition, __FILE__, __LINE__))
