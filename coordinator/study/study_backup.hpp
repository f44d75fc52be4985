// A copy of a study, taken while somebody may be writing to it.
#pragma once

#include <string>

#include "common/error.hpp"

namespace coppice {

// Writes to `to` what the study held at one moment, as one file without journals: every generation that was saved by
// then, none in part. Whoever writes to the study goes on meanwhile. The copy appears whole or not at all; a file of
// that name is replaced. Errors: as Study::open() for `from`; `to` cannot be written.
Result<void> back_up_study(const std::string& from, const std::string& to);

}  // namespace coppice
