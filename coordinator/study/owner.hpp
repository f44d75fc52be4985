// Which process runs a run, written so that another process can tell later whether it is still alive: a process
// number alone is used again, so its start time, the boot and the process-number space (containers) go with it.
#pragma once

#include <cstdint>
#include <string>

namespace coppice {

struct Owner {
  std::string host;
  std::string boot;   // /proc/sys/kernel/random/boot_id
  std::string space;  // /proc/self/ns/pid
  std::int64_t pid = 0;
  std::string start;  // field 22 of /proc/PID/stat, clock ticks since boot
  bool operator==(const Owner&) const = default;
};

enum class OwnerState : std::uint8_t {
  alive,
  gone,
  unknown,  // another host or container: cannot be seen from here
};

Owner this_process();
OwnerState state_of(const Owner& owner);

}  // namespace coppice
