// "Breed from here": an evolution whose first generation holds a given tree, as a computation of the studio.
#pragma once

#include <string>

#include "coordinator/fleet/open_evaluator.hpp"
#include "coordinator/studio/studio_session.hpp"

namespace coppice {

// Each is a new run of the study, as `coppice evolve` makes it, with a connection to the file of its own; stopped, it
// ends as after Ctrl-C and keeps the best so far. Settings: {"set": ["ga.population=200", "seed=3"]}. While it works it
// shows {"generation", "generations", "best_fitness", "mean_fitness", "best_nodes", "best_tree", "workers"}.
Breed breeding_in(const std::string& study_path, EvaluatorChoice evaluator);

}  // namespace coppice
