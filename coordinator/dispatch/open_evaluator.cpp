#include "coordinator/dispatch/open_evaluator.hpp"

#include "common/check.hpp"
#include "coordinator/dispatch/remote_endpoints.hpp"
#include "coordinator/dispatch/remote_evaluator.hpp"
#include "coordinator/dispatch/serial_evaluator.hpp"

namespace coppice {
namespace {

wire::Network network_of(const EvaluatorChoice& choice) {
  return {.security = choice.security, .lossy = choice.lossy, .port = std::nullopt};
}

}  // namespace

Result<void> check_choice(const EvaluatorChoice& choice) {
  return choice.kind == EvaluatorChoice::Kind::remote ? RemoteEndpoints::check(choice.interface, network_of(choice))
                                                      : Result<void>{};
}

namespace {

// REQUIRES: not serial.
Result<RemoteOptions> remote_options(const EvaluatorChoice& choice) {
  constexpr std::uint32_t kDefaultRemoteDomain = 0;
  RemoteOptions options;
  options.domain = choice.domain;
  options.wait_limit = choice.wait_limit;
  options.cross_check = choice.cross_check;
  options.taken_back = choice.taken_back;
  if (choice.kind == EvaluatorChoice::Kind::remote) {
    options.domain = choice.domain.value_or(kDefaultRemoteDomain);
    options.interface = choice.interface;
    options.network = network_of(choice);
    return options;
  }
  options.local_workers = choice.workers;
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
    return SerialEvaluator::make(std::move(chain), stop);
  }
  auto options = remote_options(choice);
  if (!options) {
    return tl::unexpected(options.error());
  }
  auto evaluator = RemoteEvaluator::open(std::move(chain), std::move(*options), stop);
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

}  // namespace coppice
