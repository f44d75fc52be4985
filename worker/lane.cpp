#include "worker/lane.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <new>
#include <spdlog/spdlog.h>
#include <string_view>
#include <sys/prctl.h>

#include "common/cores.hpp"

namespace coppice {
namespace {

constexpr std::chrono::seconds kIdleWait{1};
constexpr unsigned long kTimerSlackNs = 1000;     // of a paced lane: 50 us, the system's, would be felt at 500 us
constexpr std::chrono::milliseconds kMostLag{5};  // that a paced lane makes up for: late timers, not late tasks

void answer(const WorkerState& state, const wire::Task& task, const Lane::Outcome& outcome,
            wire::Writer<wire::Answer>& answers) {
  wire::Answer sample{};
  sample.protocol = state.protocol;
  sample.run_id = task.run_id;
  sample.chain = task.chain;
  sample.worker = state.worker;
  sample.batch = task.batch;
  sample.outcome = outcome.kind;
  sample.elapsed_ns = static_cast<std::uint64_t>(outcome.elapsed.count());
  sample.repeated = static_cast<std::uint32_t>(outcome.repeated);
  sample.payload = wire::lend(outcome.payload);
  if (auto ok = answers.write(sample); !ok) {
    // The coordinator offers the batch again when its deadline passes.
    spdlog::warn("an answer was not sent: {}", ok.error().message);
  }
}

std::vector<std::uint8_t> as_bytes(const std::string& text) { return {text.begin(), text.end()}; }

}  // namespace

void WorkerState::leave() {
  {
    const std::lock_guard lock(mutex_);
    leaving = true;
  }
  left_.notify_all();
}

bool WorkerState::rest_until(std::chrono::steady_clock::time_point time) {
  std::unique_lock lock(mutex_);
  return !left_.wait_until(lock, time, [this] { return leaving.load(); });
}

void give_back(const WorkerState& state, const wire::Task& task, wire::Writer<wire::Answer>& answers) {
  answer(state, task, {.kind = coppice_wire_GIVEN_BACK}, answers);
}

Lane::Lane(WorkerState& state, wire::Waiter waiter, const wire::Reader<wire::Task>& tasks,
           wire::Writer<wire::Answer>& answers)
    : state_(state), waiter_(std::move(waiter)), tasks_(tasks), answers_(answers) {}

Result<std::unique_ptr<Lane>> Lane::start(WorkerState& state, const wire::Participant& participant,
                                          const wire::Reader<wire::Task>& tasks, wire::Writer<wire::Answer>& answers,
                                          std::optional<int> core) {
  auto waiter = wire::Waiter::make(participant);
  if (!waiter) {
    return tl::unexpected(waiter.error());
  }
  if (auto ok = waiter->watch_reader(tasks.get()); !ok) {
    return tl::unexpected(ok.error());
  }
  std::unique_ptr<Lane> lane(new Lane(state, std::move(*waiter), tasks, answers));
  lane->thread_ = std::thread([raw = lane.get(), core] {
    if (core) {
      if (const auto stays = stay_on_cores({&*core, 1}); !stays) {
        spdlog::warn("an evaluating thread runs on any core: {}", stays.error().message);
      }
    }
    raw->run();
  });
  return lane;
}

Lane::~Lane() {
  if (thread_.joinable()) {
    thread_.join();
  }
}

void Lane::run() {
  if (state_.pace.count() > 0) {
    prctl(PR_SET_TIMERSLACK, kTimerSlackNs);
  }
  free_ = Clock::now();
  while (!state_.leaving) {
    const std::size_t taken = tasks_.take(1, [this](const wire::Task& task, const dds_sample_info_t& info) {
      if (info.valid_data) {
        take_one(task);
      }
    });
    if (taken == 0) {
      waiter_.wait(kIdleWait);
      free_ = Clock::now();
    }
  }
}

void Lane::take_one(const wire::Task& task) {
  const std::uint64_t run_id = state_.run_id;
  if (task.protocol != state_.protocol || (run_id != 0 && task.run_id != run_id)) {
    return;  // of a coordinator that another has followed: nobody waits for it
  }
  WorkerFigures& figures = *state_.figures;
  figures.task_bytes += task.payload._length;
  figures.busy.begin();
  const Outcome outcome = try_to_work(task);
  figures.busy.end();
  ++figures.tasks.at(outcome.kind);
  figures.answer_bytes += outcome.payload.size();
  figures.epochs += task.work == coppice_wire_EVOLVE && outcome.kind == coppice_wire_EVALUATED ? 1 : 0;
  answer(state_, task, outcome, answers_);
}

// Memory may be short for this batch and not for the next: the batch ends, the worker goes on.
Lane::Outcome Lane::try_to_work(const wire::Task& task) {
  try {
    return work(task);
  } catch (const std::bad_alloc&) {
    // Whatever these hold may be half made.
    epochs_.reset();
    evaluation_.reset();
    job_.reset();
    decoder_.reset();
    decoder_chain_.reset();
  }
  constexpr std::string_view kReason = "not enough memory to evaluate the batch";
  spdlog::warn("{}; gave it back", kReason);
  return {.kind = coppice_wire_NO_MEMORY, .payload = {kReason.begin(), kReason.end()}};
}

Lane::Outcome Lane::work(const wire::Task& task) {
  const auto chain = state_.chains.find(wire::from_wire(task.chain));
  if (chain == nullptr) {
    return {.kind = coppice_wire_CHAIN_UNKNOWN};
  }
  return task.work == coppice_wire_EVOLVE ? evolve(chain, task) : evaluate(chain, task);
}

Lane::Outcome Lane::refusal(const Error& error) {
  spdlog::warn("refused a task: {}", wire::shown(error.message.c_str()));
  return {.kind = coppice_wire_REFUSED, .payload = as_bytes(error.message)};
}

Lane::Outcome Lane::evolve(const std::shared_ptr<const PreparedChain>& chain, const wire::Task& task) {
  if (!epochs_ || epochs_->chain() != chain) {
    epochs_.emplace(chain);
  }
  const auto begin = state_.pace.count() > 0 ? free_ : Clock::now();
  std::size_t evaluated = 0;
  auto payload = epochs_->run(
      wire::view(task.payload),
      [&](std::size_t more) {
        evaluated += more;
        count(more);
        return !state_.leaving && pass_time(begin, evaluated);
      },
      state_.before_epoch_answer);
  if (!payload) {
    return payload.error().kind == ErrorKind::interrupted ? Outcome{.kind = coppice_wire_GIVEN_BACK}
                                                          : refusal(payload.error());
  }
  if (payload->size() > wire::kMaxTaskPayload) {
    return refusal({ErrorKind::bad_input, "the answer would be larger than the contract allows"});
  }
  return {.kind = coppice_wire_EVALUATED, .payload = std::move(*payload), .elapsed = Clock::now() - begin};
}

Lane::Outcome Lane::evaluate(const std::shared_ptr<const PreparedChain>& chain, const wire::Task& task) {
  auto decoded = decode(chain, task);
  if (!decoded) {
    return refusal(decoded.error());
  }
  if (auto ok = prepare(chain, decoded->job); !ok) {
    return refusal(ok.error());
  }
  const auto begin = state_.pace.count() > 0 ? free_ : Clock::now();
  const std::uint64_t repeated = evaluation_->repeated();
  std::vector<Tally> tallies;
  tallies.reserve(decoded->trees.size());
  const std::span<const Tree> trees = decoded->trees;
  const std::size_t at_once = state_.pace.count() > 0 ? 1 : evaluation_->trees_per_pass();
  while (tallies.size() < trees.size()) {
    if (state_.leaving) {
      return {.kind = coppice_wire_GIVEN_BACK};
    }
    const std::size_t some_trees = std::min<std::size_t>(at_once, trees.size() - tallies.size());
    auto some = evaluation_->evaluate(trees.subspan(tallies.size(), some_trees));
    std::move(some.begin(), some.end(), std::back_inserter(tallies));
    if (!pass_time(begin, tallies.size())) {
      return {.kind = coppice_wire_GIVEN_BACK};
    }
    count(some_trees);
  }
  decoder_->recycle(std::move(*decoded));
  if (state_.before_answer) {
    state_.before_answer(tallies);
  }
  auto payload = wire::encode_tallies(tallies);
  if (payload.size() > wire::kMaxTaskPayload) {
    return {.kind = coppice_wire_REFUSED, .payload = as_bytes("the answer would be larger than the contract allows")};
  }
  return {.kind = coppice_wire_EVALUATED,
          .payload = std::move(payload),
          .elapsed = Clock::now() - begin,
          .repeated = evaluation_->repeated() - repeated};
}

void Lane::count(std::size_t individuals) {
  state_.evaluated.fetch_add(individuals, std::memory_order_relaxed);
  state_.figures->individuals.fetch_add(individuals, std::memory_order_relaxed);
}

// A paced lane keeps to a schedule: a timer that fires late delays one individual, not all that follow it.
bool Lane::pass_time(Clock::time_point begin, std::size_t individuals) {
  if (state_.pace.count() == 0) {
    return true;
  }
  const auto due = begin + state_.pace * static_cast<std::int64_t>(individuals);
  const auto now = Clock::now();
  free_ = std::max(due, now - kMostLag);
  return due <= now || state_.rest_until(due);
}

Result<wire::DecodedTask> Lane::decode(const std::shared_ptr<const PreparedChain>& chain, const wire::Task& task) {
  if (decoder_chain_ != chain) {
    decoder_chain_ = chain;
    decoder_.emplace(chain->chain().vocabulary());
  }
  return decoder_->decode(wire::view(task.payload));
}

Result<void> Lane::prepare(const std::shared_ptr<const PreparedChain>& chain, const Job& job) {
  if (job_ != nullptr && &job_->chain() == chain.get() && job_->job() == job) {
    return {};
  }
  auto prepared = PreparedJob::make(chain, job, job_);
  if (!prepared) {
    return tl::unexpected(prepared.error());
  }
  job_ = std::move(*prepared);
  evaluation_ ? evaluation_->begin(job_) : static_cast<void>(evaluation_.emplace(job_));
  return {};
}

}  // namespace coppice
