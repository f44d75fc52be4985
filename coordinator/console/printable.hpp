// Makes text from outside (a file, a study, a command line) safe to show on a terminal.
#pragma once

#include <string>
#include <string_view>

namespace coppice {

// The text with every byte that a terminal could obey written as \xNN: control characters (C0, DEL and C1), what is
// not UTF-8, and the marks that turn the direction of writing. Other UTF-8 stays.
std::string printable(std::string_view text);

}  // namespace coppice
