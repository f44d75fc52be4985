// The commands by what a user wants: headings of `coppice --help`.
#pragma once

namespace CLI {
class App;
}

namespace coppice {

// Puts every subcommand of `app` under its heading; one that has none stands under "More". Call it after the last
// add_x().
void group_commands(CLI::App& app);

}  // namespace coppice
