#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <memory>

#include "coordinator/commands/commands.hpp"
#include "coordinator/commands/output_option.hpp"
#include "coordinator/commands/page_options.hpp"
#include "coordinator/commands/shared_flags.hpp"
#include "coordinator/console/json_line.hpp"

namespace coppice {
namespace {

struct ReportFlags {
  PageOptions page;
  OutputOption output;
  bool json = false;
};

Result<void> report_command(const ReportFlags& options, const StopFlag& stop) {
  const Result<StudyTree> given = open_study_tree(options.page.tree);
  if (!given) {
    return tl::unexpected(given.error());
  }
  const auto& [study, tree] = *given;
  if (const Result<void> checked =
          check_output("-o", options.output.path, options.output.force, options.page.tree.study);
      !checked) {
    return checked;
  }
  const PageRequest request = page_request(options.page, study, tree, options.output.path);
  if (options.json) {
    const Result<nlohmann::ordered_json> data = page_data_shown(request, study, stop);
    if (!data) {
      return tl::unexpected(data.error());
    }
    fmt::print("{}\n", json_line(*data));
    return {};
  }
  if (const Result<void> written = write_report(request, study, options.output.path, stop); !written) {
    return written;
  }
  fmt::print("report: {}\n", options.output.path);
  return {};
}

}  // namespace

void add_report(CLI::App& app, Invocation& invocation) {
  const auto options = std::make_shared<ReportFlags>();
  CLI::App* command =
      app.add_subcommand("report", "One page that shows a tree, what it is worth and what it gets wrong");
  add_page_options(*command, options->page);
  CLI::Option* output = add_output_option(*command, options->output, "The page to write", "FILE.html");
  CLI::Option* json =
      add_json_flag(*command, options->json, "Print the page's data as one JSON object instead")->excludes(output);
  command->callback([&invocation, options, output, json] {
    if (output->count() == 0 && json->count() == 0) {
      throw CLI::RequiredError("-o FILE.html or --json");
    }
    invocation.chosen = [&invocation, options] { return report_command(*options, invocation.stop); };
  });
  command->footer(
      "The page is one file: it needs no network, opens in any browser and prints.\n"
      "Examples:\n"
      "  coppice report uav.coppice -o report.html\n"
      "  coppice report uav.coppice --tree better.tree --rule 'never move when s3=0' -o better.html");
}

}  // namespace coppice
