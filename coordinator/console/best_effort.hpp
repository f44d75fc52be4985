// Standard error as the program uses it: what cannot be shown there (a full disk, a closed descriptor) is lost, and the
// work goes on. fmt::print() would throw.
#pragma once

#include <cstdio>
#include <string_view>

namespace coppice {

// Writes the text and flushes, as far as the system takes it. Never throws.
inline void show(std::FILE* out, std::string_view text) noexcept {
  static_cast<void>(std::fwrite(text.data(), 1, text.size(), out));
  static_cast<void>(std::fflush(out));
}

}  // namespace coppice
