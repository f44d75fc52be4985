// What this machine calls itself.
#pragma once

#include <array>
#include <climits>
#include <string>
#include <unistd.h>

namespace coppice {

// Empty: it has no name, or one that is longer than a name may be.
inline std::string host_name() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string();
}

}  // namespace coppice
