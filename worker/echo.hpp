// Answers every task at once with as many bytes as the task's first four (little-endian) ask for, without a chain,
// lanes or trees: what a round trip over bare DDS costs, to hold dispatch against (`coppice bench`).
#pragma once

#include "common/error.hpp"
#include "common/stop.hpp"
#include "worker/serve.hpp"

namespace coppice {

// Until `stop` is raised. Errors: as serve().
Result<void> echo(const ServeOptions& options, const StopFlag& stop);

}  // namespace coppice
