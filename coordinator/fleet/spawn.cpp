#include "coordinator/fleet/spawn.hpp"

#include <cstring>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

extern char** environ;

namespace coppice {

Result<pid_t> spawn_in_own_group(std::vector<const char*> arguments, std::optional<int> standard_io) {
  const char* const program = arguments.front();
  arguments.push_back(nullptr);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (standard_io) {
    posix_spawn_file_actions_adddup2(&actions, *standard_io, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, *standard_io, STDOUT_FILENO);
  }
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, program, &actions, &attributes, const_cast<char**>(arguments.data()), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    return failed(fmt::format("cannot start {}: {}", program, std::strerror(error)));
  }
  return pid;
}

}  // namespace coppice
