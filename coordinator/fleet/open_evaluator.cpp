#include "coordinator/fleet/open_evaluator.hpp"

#include <fmt/format.h>

#include "common/check.hpp"
#include "common/wire/credentials.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"
#include "coordinator/fleet/endpoints.hpp"
#include "coordinator/fleet/fleet_evaluator.hpp"

namespace coppice {
namespace {

wire::Network network_of(const EvaluatorChoice& choice) {
  return {.security = choice.security, .lossy = choice.lossy, .advertise = choice.advertise, .port = std::nullopt};
}

}  // namespace

Result<void> check_choice(const EvaluatorChoice& choice) {
  return choice.kind == EvaluatorChoice::Kind::remote ? Endpoints::check(choice.interface, network_of(choice))
                                                      : Result<void>{};
}

namespace {

// REQUIRES: not serial.
Result<FleetOptions> remote_options(const EvaluatorChoice& choice) {
  constexpr std::uint32_t kDefaultRemoteDomain = 0;
  FleetOptions options;
  options.domain = choice.domain;
  options.wait_limit = choice.wait_limit;
  options.cross_check = choice.cross_check;
  options.watch_workers = choice.watch_workers;
  if (choice.metrics != nullptr) {
    options.watch = [metrics = choice.metrics, folder = choice.security](FleetStatus status) {
      status.certificates = wire::certificate_ends(folder);
      metrics->fleet(status);
    };
  }
  if (choice.kind == EvaluatorChoice::Kind::remote) {
    options.domain = choice.domain.value_or(kDefaultRemoteDomain);
    options.interface = choice.interface;
    options.network = network_of(choice);
    return options;
  }
  options.local_workers = choice.workers;
  options.may_stay_home = true;
  options.worker_program = choice.worker_program;
  if (choice.worker_program.empty()) {
    auto program = find_worker_program();
    if (!program) {
      return tl::unexpected(program.error());
    }
    options.worker_program = std::move(*program);
  }
  return options;
}

}  // namespace

Result<std::unique_ptr<Evaluator>> open_evaluator(std::shared_ptr<const Chain> chain, const EvaluatorChoice& choice,
                                                  const StopFlag& stop) {
  if (choice.kind == EvaluatorChoice::Kind::serial) {
    return SerialEvaluator::make(std::move(chain), stop, choice.threads);
  }
  auto options = remote_options(choice);
  if (!options) {
    return tl::unexpected(options.error());
  }
  auto evaluator = FleetEvaluator::open(std::move(chain), std::move(*options), stop);
  if (!evaluator) {
    return tl::unexpected(evaluator.error());
  }
  return std::unique_ptr<Evaluator>(std::move(*evaluator));
}

Result<std::unique_ptr<EvaluatorPool>> open_pool(std::shared_ptr<const Chain> chain, const EvaluatorChoice& choice,
                                                 const StopFlag& stop) {
  COPPICE_CHECK(choice.kind != EvaluatorChoice::Kind::serial);
  auto options = remote_options(choice);
  if (!options) {
    return tl::unexpected(options.error());
  }
  return EvaluatorPool::open(std::move(chain), std::move(*options), stop);
}

std::string in_words(const EvaluatorChoice& choice) {
  switch (choice.kind) {
    case EvaluatorChoice::Kind::serial:
      return "serial";
    case EvaluatorChoice::Kind::local:
      return fmt::format("{} local worker{}", choice.workers, choice.workers == 1 ? "" : "s");
    case EvaluatorChoice::Kind::remote:
      break;
  }
  return "remote workers";
}

}  // namespace coppice
