// One file of another tool turned into a chain with its problem: reads it, solves it or takes a policy that is given,
// and makes the chain. What the command `coppice import` calls. Nothing is written.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "common/error.hpp"
#include "coordinator/exchange/format.hpp"
#include "coordinator/exchange/imported.hpp"
#include "coordinator/exchange/problem_file.hpp"

namespace coppice {

struct ImportSettings {
  std::string source;
  std::optional<SourceFormat> format = {};  // none: told from the content
  ProblemFile problem = {};
  std::string q = {};       // file; empty: none
  std::string policy = {};  // file; empty: none
  bool solve = false;
  std::uint64_t min_visits = 1;      // of a log: solving takes no action that was tried less often where it need not
  std::optional<double> gamma = {};  // none: the problem's discount
  std::optional<std::uint32_t> horizon = {};  // steps
};

// What is done at the moment, and the share of it; false to stop. May be empty.
using ImportProgress = std::function<bool(std::string_view what, double share)>;

// Errors name file and line, or the flag, what was found and what was expected; interrupted.
Result<Imported> import_source(const ImportSettings& settings, const ImportProgress& go_on = {});

}  // namespace coppice
