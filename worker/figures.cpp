#include "worker/figures.hpp"

#include <fmt/format.h>

#include "common/metrics/exposition.hpp"
#include "common/wire/credentials.hpp"
#include "common/wire/topics.hpp"

namespace coppice {

void BusyTime::pass(Clock::time_point now) const {
  passed_ += (now - since_) * static_cast<std::int64_t>(lanes_);
  since_ = now;
}

void BusyTime::begin() {
  const std::lock_guard lock(mutex_);
  pass(Clock::now());
  ++lanes_;
}

void BusyTime::end() {
  const std::lock_guard lock(mutex_);
  pass(Clock::now());
  --lanes_;
}

double BusyTime::seconds() const {
  const std::lock_guard lock(mutex_);
  pass(Clock::now());
  return std::chrono::duration<double>(passed_).count();
}

std::size_t BusyTime::lanes() const {
  const std::lock_guard lock(mutex_);
  return lanes_;
}

Health WorkerFigures::health() const {
  const auto turned = std::chrono::steady_clock::time_point(std::chrono::steady_clock::duration(turned_.load()));
  const auto since = std::chrono::steady_clock::now() - turned;
  const std::lock_guard lock(mutex_);
  if (turned.time_since_epoch().count() != 0 && since > kLongestTurn) {
    return {.alive = false,
            .ready = false,
            .words = fmt::format("hangs: its main loop stands still for {} s",
                                 std::chrono::duration_cast<std::chrono::seconds>(since).count())};
  }
  return {.alive = true, .ready = serves_, .words = words_};
}

void WorkerFigures::turn() {
  turned_ = std::chrono::steady_clock::now().time_since_epoch().count();
  manager.alive();
}

void WorkerFigures::say(std::string words) {
  manager.status(words);
  const std::lock_guard lock(mutex_);
  words_ = std::move(words);
}

void WorkerFigures::serve(const std::string& coordinator) {
  ++coordinators;
  serves_ = true;
  waits_ = false;
  say("serving the coordinator " + coordinator);
}

void WorkerFigures::wait_for(const std::string& what) {
  serves_ = false;
  waits_ = true;
  say("waiting for " + what);
}

std::string to_metrics(const WorkerFigures& figures, const std::string& version, const std::string& security) {
  constexpr std::array<const char*, WorkerFigures::kOutcomes> kNames = {"evaluated", "given_back", "chain_unknown",
                                                                        "refused", "no_memory"};
  static_assert(coppice_wire_EVALUATED == 0 && coppice_wire_GIVEN_BACK == 1 && coppice_wire_CHAIN_UNKNOWN == 2 &&
                coppice_wire_REFUSED == 3 && coppice_wire_NO_MEMORY == 4);
  Exposition out;
  out.gauge("coppice_worker_info", "1; which build this is.", 1.0,
            {{"version", version}, {"protocol", std::to_string(wire::kProtocolVersion)}});
  out.gauge("coppice_worker_serving", "1 while a coordinator is served, 0 while none is there.",
            figures.serves() ? 1.0 : 0.0);
  out.counter("coppice_worker_coordinators_total", "Coordinators that were served, one after another.",
              static_cast<double>(figures.coordinators));
  out.counter("coppice_worker_individuals_total", "Individuals evaluated.", static_cast<double>(figures.individuals));
  out.counter("coppice_worker_epochs_total", "Epochs of demes run.", static_cast<double>(figures.epochs));
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    out.counter("coppice_worker_tasks_total", "Tasks, by what became of them.", static_cast<double>(figures.tasks[i]),
                {{"outcome", kNames[i]}});
  }
  out.gauge("coppice_worker_lanes", "Evaluating threads.", figures.lanes);
  out.gauge("coppice_worker_lanes_busy", "Of them, at work now.", static_cast<double>(figures.busy.lanes()));
  out.counter("coppice_worker_busy_seconds_total", "Time that lanes were at work, summed.", figures.busy.seconds());
  out.counter("coppice_worker_received_bytes_total", "Payloads that came, by kind.",
              static_cast<double>(figures.task_bytes), {{"kind", "task"}});
  out.counter("coppice_worker_received_bytes_total", "", static_cast<double>(figures.chain_bytes), {{"kind", "chain"}});
  out.counter("coppice_worker_sent_bytes_total", "Payloads of answers.", static_cast<double>(figures.answer_bytes));
  out.gauge("coppice_worker_chains", "Chains held in memory.", figures.chains);
  for (const auto& [file, end] : wire::certificate_ends(security)) {
    out.gauge("coppice_certificate_end_seconds", "When a certificate of this identity ends, in Unix time.",
              static_cast<double>(end), {{"file", file}});
  }
  add_process(out);
  return out.text();
}

}  // namespace coppice
