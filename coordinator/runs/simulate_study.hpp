// A tree in the simulator of a study: the problem's own, or that of its world.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/learning/simulate.hpp"
#include "coordinator/learning/world.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

// Whether world_of() finds one.
bool has_simulator(const Study& study);

// The problem's own simulator, if `simulator` (a command) or the study names one, else the study's world. Errors: it
// has none.
Result<World> world_of(const Study& study, const std::string& simulator = {});

// Keeps the command in the study, if one is given, for the next time: to be called once it has served. Errors: as
// Study::open() and Study::save_problem().
Result<void> keep_simulator(const std::string& study_path, const std::string& simulator);

// Nothing where the study has no world and no simulator. Errors name the flag, as check_score_settings(); interrupted.
Result<std::optional<std::vector<EpisodeRecord>>> simulated(const Study& study, const Tree& tree,
                                                            const SimulateSettings& settings,
                                                            const std::string& simulator, const StopFlag& stop);

// The same for many trees, all on the same episodes and, of the problem's own simulator, in one process.
// [trees][episodes] `done` is told how many trees are done; may be empty.
Result<std::optional<std::vector<std::vector<EpisodeRecord>>>> simulated_all(
    const Study& study, std::span<const Tree> trees, const SimulateSettings& settings, const std::string& simulator,
    const StopFlag& stop, const std::function<void(std::size_t)>& done);

}  // namespace coppice
