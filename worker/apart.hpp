// Evaluates one task and ends, for a coordinator that will not share a process with it (coordinator/fleet/apart.hpp):
// standard input holds whether the task is an epoch of a deme (u8, else trees), the length of a chain's canonical bytes
// (u64), these, and the task's payload; the answer's payload goes to standard output.
#pragma once

#include "common/error.hpp"

namespace coppice {

// Errors: input that ends too soon or does not decode, output that cannot be written.
Result<void> evaluate_apart();

}  // namespace coppice
