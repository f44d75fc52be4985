// What holds for every EvolveConfig that one of its readers accepted.
#pragma once

#include "coordinator/evolution/config_text.hpp"

namespace coppice::fuzz {

// Its JSON gives exactly the same, and check_config() on words() refuses it or it makes a valid job. Aborts otherwise.
void check_configuration(const EvolveConfig& config);

}  // namespace coppice::fuzz
