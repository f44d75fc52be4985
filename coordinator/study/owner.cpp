#include "coordinator/study/owner.hpp"

#include <array>
#include <climits>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <unistd.h>
#include <vector>

#include "common/host_name.hpp"

namespace coppice {
namespace {

std::string first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

// Start time of a live process; none if there is none or only its exit status is left.
std::optional<std::string> start_of(std::int64_t pid) {
  // proc(5): "pid (name) state ..." where the name may hold anything, so count from the last ')': state is field 3,
  // start time field 22.
  constexpr std::size_t kStart = 22 - 3;
  const std::string line = first_line(fmt::format("/proc/{}/stat", pid));
  const std::size_t name_end = line.rfind(')');
  if (name_end == std::string::npos) {
    return std::nullopt;
  }
  std::istringstream rest(line.substr(name_end + 1));
  const std::vector<std::string> fields{std::istream_iterator<std::string>(rest), {}};
  if (fields.size() <= kStart || fields[0] == "Z" || fields[0] == "X") {
    return std::nullopt;
  }
  return fields[kStart];
}

std::string link_target(const char* path) {
  std::array<char, PATH_MAX> target{};
  const ssize_t length = ::readlink(path, target.data(), target.size());
  return length < 0 ? std::string() : std::string(target.data(), static_cast<std::size_t>(length));
}

}  // namespace

Owner this_process() {
  const std::int64_t pid = ::getpid();
  return {host_name(), first_line("/proc/sys/kernel/random/boot_id"), link_target("/proc/self/ns/pid"), pid,
          start_of(pid).value_or("")};
}

OwnerState state_of(const Owner& owner) {
  const Owner here = this_process();
  if (here.boot.empty() || owner.boot.empty()) {
    return OwnerState::unknown;
  }
  if (owner.boot != here.boot) {
    return owner.host == here.host ? OwnerState::gone : OwnerState::unknown;  // gone: this host has booted since
  }
  if (owner.space != here.space) {
    return OwnerState::unknown;
  }
  return start_of(owner.pid) == owner.start ? OwnerState::alive : OwnerState::gone;
}

}  // namespace coppice
