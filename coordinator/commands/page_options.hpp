// What `coppice report`, `coppice run` and `coppice studio` share: which tree the page is about and how it is measured.
#pragma once

#include <string>
#include <vector>

#include "common/stop.hpp"
#include "coordinator/commands/simulate_option.hpp"
#include "coordinator/commands/study_tree.hpp"
#include "coordinator/studio/page_data.hpp"

namespace CLI {
class App;
}

namespace coppice {

struct PageOptions {
  StudyTreeOption tree;
  SimulateOption simulate;
  std::uint32_t resamples = 100;
  std::vector<std::string> rules;  // besides those that everybody wants to hold
};

void add_page_options(CLI::App& command, PageOptions& options);

// A tree that a run gave is shown pruned, as far as that holds in every possible state; one that was named is shown as
// it is. `output`: of the report, to name the command that makes it; empty: the studio.
PageRequest page_request(const PageOptions& options, const Study& study, const Tree& tree, const std::string& output);

// page_data() with progress on standard error.
Result<nlohmann::ordered_json> page_data_shown(const PageRequest& request, const Study& study, const StopFlag& stop);

// Computes the report, with progress on standard error, and writes the page. Errors: page_data(), the file.
Result<void> write_report(const PageRequest& request, const Study& study, const std::string& output,
                          const StopFlag& stop);

}  // namespace coppice
