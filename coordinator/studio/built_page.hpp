// page/built/page.html, embedded in the program by CMake.
#pragma once

#include <string_view>

namespace coppice {

std::string_view built_page();

}  // namespace coppice
