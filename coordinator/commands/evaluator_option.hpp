// --workers N | --serial | --remote, and where remote workers find us: who evaluates the trees of a command.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "common/metrics/outlet.hpp"
#include "coordinator/fleet/open_evaluator.hpp"

namespace CLI {
class App;
}

namespace coppice {

struct EvaluatorOption {
  std::optional<std::size_t> workers;
  bool serial = false;
  std::optional<std::size_t> threads;
  bool remote = false;
  std::optional<std::string> interface;
  std::string advertise;
  std::string security;
  bool lossy = false;
  std::optional<double> cross_check;
  std::optional<std::uint32_t> domain;
  std::optional<std::uint32_t> wait_seconds;
  std::string worker_program;
  MetricsTargets metrics;
};

void add_evaluator_option(CLI::App& command, EvaluatorOption& option);

// What open_evaluator() takes; metrics are served from now on, if they were asked for. Errors name the flag; a worker
// program that cannot be started is among them.
Result<EvaluatorChoice> evaluator_choice(const EvaluatorOption& option);

}  // namespace coppice
