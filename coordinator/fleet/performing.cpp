// What the dispatcher wants done, done.
#include <algorithm>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <variant>

#include "common/check.hpp"
#include "coordinator/fleet/fleet.hpp"

namespace coppice {

Result<void> Fleet::perform(Actions& actions) {
  send_own_core_last(actions);
  for (const Action& action : actions.actions) {
    if (auto ok = std::visit([this](const auto& wanted) { return perform(wanted); }, action); !ok) {
      return ok;
    }
  }
  return {};
}

// Puts the tasks of a local worker that keeps to the core of this thread behind those of all others. Such a worker
// begins as soon as its task is written, and the system may let it run for milliseconds before this thread can write to
// the others (on two cores, one generation in three lost 2 to 4 ms in this way). Tasks may be sent in any order.
void Fleet::send_own_core_last(Actions& actions) const {
  if (!local_) {
    return;
  }
  const int core = sched_getcpu();
  std::stable_partition(actions.actions.begin(), actions.actions.end(), [&](const Action& action) {
    const auto* const send = std::get_if<SendTask>(&action);
    return send == nullptr || !local_->keeps_to(dispatcher_.roster().find(send->worker)->pid, core);
  });
}

Result<void> Fleet::perform(const OpenLink& action) {
  auto link = Link::open(dds_.participant, dds_.waiter, action.worker);
  if (!link) {
    spdlog::error("cannot serve a worker: {}", link.error().message);
    return {};
  }
  links_.insert_or_assign(action.worker, std::move(*link));
  settling_ = true;
  return {};
}

Result<void> Fleet::perform(const CloseLink& action) {
  links_.erase(action.worker);
  return {};
}

Result<void> Fleet::perform(const SendTask& action) {
  const auto link = links_.find(action.worker);
  if (link == links_.end()) {
    events_.emplace_back(SendFailed{action.worker, action.batch.id, "nothing to write to it with"});
    return {};
  }
  const RequestWork& work = *works_.at(action.batch.request);
  const auto payload = work.encode(action.batch.first, action.batch.count);
  if (auto ok = link->second.send_task(action.batch.id, work.terms().work.kind, payload, run_); !ok) {
    events_.emplace_back(SendFailed{action.worker, action.batch.id, ok.error().message});
    return {};
  }
  statistics_.sent_bytes += payload.size();
  if (options_.batch_sent) {
    options_.batch_sent(dispatcher_.roster().find(action.worker)->pid);
  }
  return {};
}

Result<void> Fleet::perform(const SendBlocks& action) {
  if (const auto link = links_.find(action.worker); link != links_.end()) {
    link->second.request_blocks(action.first, action.count);
    link->second.send_blocks(chain_bytes_, run_);
  }
  return {};
}

Result<void> Fleet::perform(const Announce&) {
  if (auto ok = announce(); !ok) {
    spdlog::warn("{}", ok.error().message);
  }
  return {};
}

Result<void> Fleet::perform(const Compute& action) {
  if (action.apart) {
    return compute_apart(action);
  }
  const auto begin = Clock::now();
  auto outcomes = works_.at(action.request)->compute(action.units);
  if (!outcomes) {
    return tl::unexpected(outcomes.error());
  }
  events_.emplace_back(Computed{action.id, Clock::now() - begin, std::move(*outcomes), {}});
  return {};
}

Result<void> Fleet::compute_apart(const Compute& action) {
  COPPICE_CHECK(action.units.size() == 1);
  if (options_.worker_program.empty()) {
    auto program = find_worker_program();
    if (!program) {
      return tl::unexpected(program.error());
    }
    options_.worker_program = std::move(*program);
  }
  const Unit unit{action.request, action.units.front()};
  auto apart = Apart::start({.program = options_.worker_program,
                             .unit = unit,
                             .work = works_.at(unit.request)->terms().work.kind,
                             .chain_bytes = chain_bytes_,
                             .payload = works_.at(unit.request)->encode(unit.index, 1)},
                            [this] { dds_.waiter.wake(); });
  if (!apart) {
    return tl::unexpected(apart.error());
  }
  apart_.emplace(action.id, std::move(*apart));
  return {};
}

Result<void> Fleet::perform(const StartProcess& action) {
  const auto pid = local_->start_again(action.place);
  if (pid) {
    events_.emplace_back(ProcessStarted{action.place, *pid});
  } else {
    events_.emplace_back(ProcessEnded{action.place, 0, false, pid.error().message});
  }
  return {};
}

Result<void> Fleet::perform(const Say& action) {
  switch (action.level) {
    case Say::Level::debug:
      spdlog::debug("{}", action.text);
      break;
    case Say::Level::warn:
      spdlog::warn("{}", action.text);
      break;
    case Say::Level::error:
      spdlog::error("{}", action.text);
      break;
  }
  return {};
}

Error Fleet::in_words(const Failure& failure) const {
  Error error = failure.error;
  if (failure.deadly) {
    error.message += ": " + works_.at(failure.deadly->request)->in_words(failure.deadly->index);
  }
  return error;
}

}  // namespace coppice
