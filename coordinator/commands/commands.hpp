// The subcommands of `coppice`, one file each. add_x() declares the flags of one; parsing a command line that names it
// sets Invocation::chosen, which main() then calls once.
#pragma once

#include <functional>

#include "common/error.hpp"
#include "common/stop.hpp"

namespace CLI {
class App;
}

namespace coppice {

struct Invocation {
  const StopFlag& stop;
  std::function<Result<void>()> chosen;
};

// REQUIRES: `invocation` outlives `app`.
void add_learn(CLI::App& app, Invocation& invocation);
void add_import(CLI::App& app, Invocation& invocation);
void add_evolve(CLI::App& app, Invocation& invocation);
void add_evaluate(CLI::App& app, Invocation& invocation);
void add_score(CLI::App& app, Invocation& invocation);
void add_front(CLI::App& app, Invocation& invocation);
void add_verify(CLI::App& app, Invocation& invocation);
void add_explain(CLI::App& app, Invocation& invocation);
void add_edit(CLI::App& app, Invocation& invocation);
void add_table(CLI::App& app, Invocation& invocation);
void add_prune(CLI::App& app, Invocation& invocation);
void add_export(CLI::App& app, Invocation& invocation);
void add_draw(CLI::App& app, Invocation& invocation);
void add_synth(CLI::App& app, Invocation& invocation);
void add_info(CLI::App& app, Invocation& invocation);
void add_sweep(CLI::App& app, Invocation& invocation);
void add_bench(CLI::App& app, Invocation& invocation);
void add_refine(CLI::App& app, Invocation& invocation);
void add_report(CLI::App& app, Invocation& invocation);
void add_studio(CLI::App& app, Invocation& invocation);
void add_reproduce(CLI::App& app, Invocation& invocation);
void add_workers(CLI::App& app, Invocation& invocation);
void add_run(CLI::App& app, Invocation& invocation);
void add_check(CLI::App& app, Invocation& invocation);
void add_backup(CLI::App& app, Invocation& invocation);
void add_help(CLI::App& app, Invocation& invocation);
// REQUIRES: called after all others, which it is about.
void add_completion(CLI::App& app, Invocation& invocation);

}  // namespace coppice
