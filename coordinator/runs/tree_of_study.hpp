// Which tree of a study is meant: the best of a run, or one that is given as text or in a file.
#pragma once

#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/evolution/config.hpp"
#include "common/tree/tree.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {

// The best tree of the run; of the last finished run, else the last that has a tree, where none is given. Errors
// (bad_input): there is no such run.
Result<Tree> tree_of_run(const Study& study, std::optional<RunId> run);

// How that run, or the one that tree_of_run() takes where none is given, was set up. Nothing: the study has no such run
// yet. Errors (bad_input): there is no run of that number.
Result<std::optional<EvolveConfig>> config_of_run(const Study& study, std::optional<RunId> run);

// A file of that name if there is one, else the text itself. Errors (bad_input): malformed text, naming file, line and
// column; a file that does not hold exactly one tree (as text, JSON, or XML of BehaviorTree.CPP 4).
Result<Tree> tree_of_text_or_file(const Study& study, const std::string& text);

}  // namespace coppice
