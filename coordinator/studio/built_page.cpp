#include "coordinator/studio/built_page.hpp"

#include <cstddef>

extern "C" const char coppice_built_page[];      // NOLINT: an assembler made them, built_page.S.in
extern "C" const char coppice_built_page_end[];  // NOLINT

namespace coppice {

std::string_view built_page() {
  return {coppice_built_page, static_cast<std::size_t>(coppice_built_page_end - coppice_built_page)};
}

}  // namespace coppice
