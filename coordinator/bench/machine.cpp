#include "coordinator/bench/machine.hpp"

#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <sched.h>
#include <string_view>
#include <sys/utsname.h>
#include <thread>

namespace coppice {
namespace {

// What follows `key` and its separator in the first line that begins with it; empty if none does.
std::string value_in(const char* file, std::string_view key, char separator) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t at = line.find(separator);
    if (line.rfind(key, 0) == 0 && at != std::string::npos) {
      const std::size_t begin = line.find_first_not_of(" \t\"", at + 1);
      const std::size_t end = line.find_last_not_of(" \t\"");
      return begin == std::string::npos ? "" : line.substr(begin, end - begin + 1);
    }
  }
  return {};
}

std::string or_unknown(const std::string& text) { return text.empty() ? "unknown" : text; }

}  // namespace

Machine this_machine() {
  Machine machine;
  machine.processor = or_unknown(value_in("/proc/cpuinfo", "model name", ':'));
  cpu_set_t usable;
  const bool counted = sched_getaffinity(0, sizeof usable, &usable) == 0;
  machine.cores = counted ? static_cast<unsigned>(CPU_COUNT(&usable)) : std::thread::hardware_concurrency();
  utsname system{};
  const bool named = uname(&system) == 0;
  machine.system = fmt::format("{}, {} {}", or_unknown(value_in("/etc/os-release", "PRETTY_NAME", '=')),
                               named ? system.sysname : "unknown", named ? system.release : "kernel");
  double loads[1] = {};
  machine.load = getloadavg(loads, 1) == 1 ? loads[0] : 0.0;
  return machine;
}

}  // namespace coppice
