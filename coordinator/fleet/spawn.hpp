// Starts a program in a process group of its own, so that Ctrl-C at the terminal reaches the coordinator only.
#pragma once

#include <optional>
#include <sys/types.h>
#include <vector>

#include "common/error.hpp"

namespace coppice {

// `arguments`: the program's path first, without the closing null. Of our descriptors the child gets the standard three
// alone: a child that outlives us must not keep the coordinator's port. `standard_io`, if given, is its standard input
// and output. Error: it cannot be started (the message names the program and the reason).
Result<pid_t> spawn_in_own_group(std::vector<const char*> arguments, std::optional<int> standard_io = {});

}  // namespace coppice
