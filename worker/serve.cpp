#include "worker/serve.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <fmt/format.h>
#include <memory>
#include <mutex>
#include <optional>
#include <spdlog/spdlog.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "common/wire/credentials.hpp"
#include "worker/absence.hpp"
#include "worker/allegiance.hpp"
#include "worker/chain_cache.hpp"
#include "worker/lane.hpp"

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kHelloInterval{250};
constexpr std::chrono::milliseconds kBlockStall{500};  // without a block for this long, the missing are asked for again
constexpr std::int64_t kFarewellMs = 1000;  // for the coordinator to receive the last answers and the last Hello
// Without a coordinator for this long, a worker starts over as if it were new: its coordinator's name may stand for
// another address by now, and DDS 0.10 does not always find its way back after a long time apart.
constexpr std::chrono::seconds kLonely{30};
constexpr std::chrono::seconds kRetry{1};           // when it cannot even look
constexpr std::chrono::seconds kComplainEvery{60};  // about that
constexpr std::size_t kMostPerTake = 256;
constexpr int kMostFailedChains = 3;
static_assert(ChainStore::kMaxChains <= coppice_wire_MAX_CHAINS_HELD);

// Sleeps, but not past the stop flag.
class Rest {
 public:
  explicit Rest(const StopFlag& stop)
      : stop_(stop), wake_(stop.on_raise([this] {
          const std::lock_guard lock(mutex_);
          raised_.notify_all();
        })) {}

  void for_a_while(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    raised_.wait_for(lock, time, [this] { return stop_.raised(); });
  }

 private:
  const StopFlag& stop_;
  std::mutex mutex_;
  std::condition_variable raised_;
  StopFlag::Wake wake_;  // last: gone before what it uses
};

class Server {
 public:
  // `state` and `cache`, if there is one, outlive it.
  static Result<std::unique_ptr<Server>> open(const ServeOptions& options, WorkerState& state, ChainCache* cache);
  ~Server() { stop_lanes(); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // Until `stop` is raised, or nobody has been there for kLonely.
  Result<void> run(const StopFlag& stop, Absence& absence);

 private:
  Server(const ServeOptions& options, WorkerState& state, ChainCache* cache, wire::Participant participant,
         wire::Waiter waiter, wire::Reader<wire::Control> controls, wire::Reader<wire::Task> tasks,
         wire::Reader<wire::ChainBlock> blocks, wire::Writer<wire::Hello> hellos, wire::Writer<wire::Answer> answers,
         wire::Writer<wire::ChainRequest> requests)
      : options_(options),
        state_(state),
        cache_(cache),
        participant_(std::move(participant)),
        waiter_(std::move(waiter)),
        controls_(std::move(controls)),
        tasks_(std::move(tasks)),
        blocks_(std::move(blocks)),
        hellos_(std::move(hellos)),
        answers_(std::move(answers)),
        requests_(std::move(requests)),
        allegiance_(controls_, {options.protocol, options.golden, options.version}) {}

  Result<void> start_lanes();
  Result<void> take_controls();
  void meet(const wire::Control& control);
  Result<void> take_blocks();
  Result<void> finish_chain();
  void stop_lanes();
  void request_missing();
  void say_hello();
  void say_alone();
  void leave();

  const ServeOptions options_;
  WorkerState& state_;
  ChainCache* const cache_;
  wire::Participant participant_;
  wire::Waiter waiter_;
  wire::Reader<wire::Control> controls_;
  wire::Reader<wire::Task> tasks_;
  wire::Reader<wire::ChainBlock> blocks_;
  wire::Writer<wire::Hello> hellos_;
  wire::Writer<wire::Answer> answers_;
  wire::Writer<wire::ChainRequest> requests_;
  Allegiance allegiance_;
  std::vector<std::unique_ptr<Lane>> lanes_;  // after what they use: joined first

  std::optional<Assembly> assembly_;
  int failed_chains_ = 0;            // in a row
  std::uint32_t requested_end_ = 0;  // blocks before it have been asked for
  Clock::time_point last_block_;
  Clock::time_point alone_since_ = Clock::now();
  wire::CertificateWatch certificates_{options_.network.security};
  Clock::time_point next_hello_;
};

Result<std::unique_ptr<Server>> Server::open(const ServeOptions& options, WorkerState& state, ChainCache* cache) {
  const auto configuration = wire::worker_configuration(options.coordinator, options.domain, options.network);
  if (!configuration) {
    return tl::unexpected(configuration.error());
  }
  auto participant = wire::Participant::join(options.domain, *configuration);
  if (!participant) {
    return tl::unexpected(participant.error());
  }
  const std::string partition = wire::partition_of(state.worker);
  auto waiter = wire::Waiter::make(*participant);
  auto controls = wire::Reader<wire::Control>::make(*participant);
  auto tasks = wire::Reader<wire::Task>::make(*participant, partition);
  auto blocks = wire::Reader<wire::ChainBlock>::make(*participant, partition);
  auto hellos = wire::Writer<wire::Hello>::make(*participant);
  auto answers = wire::Writer<wire::Answer>::make(*participant);
  auto requests = wire::Writer<wire::ChainRequest>::make(*participant);
  std::optional<Error> error;
  const auto check = [&error](const auto& result) {
    if (!result && !error) {
      error = result.error();
    }
  };
  check(waiter), check(controls), check(tasks), check(blocks), check(hellos), check(answers), check(requests);
  if (!error) {
    check(waiter->watch_reader(controls->get()));
    check(waiter->watch_reader(blocks->get()));
  }
  if (error) {
    return tl::unexpected(*error);
  }
  std::unique_ptr<Server> server(new Server(options, state, cache, std::move(*participant), std::move(*waiter),
                                            std::move(*controls), std::move(*tasks), std::move(*blocks),
                                            std::move(*hellos), std::move(*answers), std::move(*requests)));
  if (auto ok = server->start_lanes(); !ok) {
    return tl::unexpected(ok.error());
  }
  return server;
}

Result<void> Server::start_lanes() {
  for (std::uint32_t i = 0; i < options_.threads; ++i) {
    auto lane = Lane::start(state_, participant_, tasks_, answers_,
                            options_.cores.empty() ? std::nullopt : std::optional(options_.cores.at(i)));
    if (!lane) {
      stop_lanes();
      state_.come_back();  // for the next try
      return tl::unexpected(lane.error());
    }
    lanes_.push_back(std::move(*lane));
  }
  return {};
}

Result<void> Server::run(const StopFlag& stop, Absence& absence) {
  const auto wake = stop.on_raise([this] { waiter_.wake(); });
  Result<void> outcome;
  while (outcome && !stop.raised()) {
    options_.figures->turn();
    if (const std::string line = certificates_.look(); !line.empty()) {
      spdlog::warn("{}", line);
    }
    outcome = take_controls();
    if (outcome) {
      outcome = take_blocks();
    }
    if (assembly_ && Clock::now() - last_block_ > kBlockStall) {
      requested_end_ = 0;
      request_missing();
    }
    if (Clock::now() >= next_hello_) {
      say_hello();
    }
    if (state_.run_id != 0) {
      alone_since_ = Clock::now();
      absence.somebody();
    } else {
      say_alone();
      absence.nobody([this] { return participant_.others(); });
      if (Clock::now() - alone_since_ > kLonely) {
        break;
      }
    }
    waiter_.wait(next_hello_ - Clock::now());
  }
  leave();
  return outcome;
}

Result<void> Server::take_controls() {
  const auto now = Clock::now();
  allegiance_.listen(
      now, [this](const wire::Control& control) { meet(control); },
      [this] {
        if (state_.run_id.exchange(0) != 0) {
          spdlog::info("the coordinator is gone; waiting for the next");
        }
      });
  if (const auto refusal = allegiance_.refusal(now)) {
    return failed(*refusal);
  }
  return {};
}

void Server::meet(const wire::Control& control) {
  if (state_.run_id.exchange(control.run_id) != control.run_id) {
    options_.figures->serve(fmt::format("{} (pid {})", wire::shown(control.host), control.pid));
    spdlog::info("serving the coordinator {} (pid {})", wire::shown(control.host), control.pid);
  }
  const ChainHash hash = wire::from_wire(control.chain);
  if (state_.chains.find(hash) != nullptr) {
    assembly_.reset();
  } else if (!assembly_ || assembly_->hash() != hash || assembly_->size() != control.chain_size) {
    auto assembly = Assembly::start(hash, control.chain_size, wire::kBlockBytes);
    if (!assembly) {
      spdlog::error("{}", assembly.error().message);
      return;
    }
    assembly_ = std::move(*assembly);
    requested_end_ = 0;
    if (cache_ != nullptr) {
      if (const std::size_t blocks = cache_->resume(*assembly_); blocks > 0) {
        spdlog::info("chain {}: {} of {} blocks are in the cache", hash.hex(), blocks, assembly_->blocks());
      }
    }
  }
  if (assembly_) {
    requested_end_ = 0;  // another coordinator has not been asked yet
    request_missing();
  }
  say_hello();
}

void Server::request_missing() {
  const auto run = assembly_->missing(wire::kBlockWindow);
  if (!run || run->first < requested_end_ || state_.run_id == 0) {
    return;
  }
  wire::ChainRequest request{};
  request.protocol = options_.protocol;
  request.run_id = state_.run_id;
  request.chain = wire::to_wire(assembly_->hash());
  request.worker = state_.worker;
  request.first = run->first;
  request.count = run->count;
  requested_end_ = run->first + run->count;
  last_block_ = Clock::now();
  if (auto ok = requests_.write(request); !ok) {
    spdlog::warn("could not ask for the chain: {}", ok.error().message);
  }
}

Result<void> Server::take_blocks() {
  blocks_.take(kMostPerTake, [&](const wire::ChainBlock& block, const dds_sample_info_t& info) {
    if (!info.valid_data || !assembly_ || wire::from_wire(block.chain) != assembly_->hash()) {
      return;
    }
    if (auto ok = assembly_->add(block.index, wire::view(block.payload)); !ok) {
      spdlog::warn("dropped a sample: {}", ok.error().message);
      return;
    }
    last_block_ = Clock::now();
    options_.figures->chain_bytes += block.payload._length;
  });
  if (assembly_) {
    if (cache_ != nullptr) {
      cache_->keep(*assembly_);
    }
    if (assembly_->complete()) {
      return finish_chain();
    }
    request_missing();
  }
  return {};
}

Result<void> Server::finish_chain() {
  const ChainHash hash = assembly_->hash();
  auto chain = std::move(*assembly_).finish();
  assembly_.reset();
  if (cache_ != nullptr && chain) {
    cache_->done();
  } else if (cache_ != nullptr) {
    cache_->discard();
  }
  if (!chain) {
    if (++failed_chains_ >= kMostFailedChains) {
      return failed(fmt::format("chain {}: {} (in {} transfers)", hash.hex(),
                                wire::shown(chain.error().message.c_str()), failed_chains_));
    }
    spdlog::error("chain {}: {}", hash.hex(), wire::shown(chain.error().message.c_str()));
    state_.run_id = 0;  // the coordinator hears of it and announces its run again, which starts over
    say_hello();
    return {};
  }
  spdlog::info("holds chain {}: {} states, {} transitions", hash.hex(), (*chain)->chain().states(),
               (*chain)->chain().transitions());
  failed_chains_ = 0;
  state_.chains.add(hash, std::move(*chain));
  options_.figures->chains = static_cast<std::uint32_t>(state_.chains.held().size());
  say_hello();
  return {};
}

void Server::say_hello() {
  next_hello_ = Clock::now() + kHelloInterval;
  wire::Hello hello{};
  hello.protocol = options_.protocol;
  hello.worker = state_.worker;
  hello.run_id = state_.run_id;
  wire::put_text(hello.version, options_.version);
  wire::put_text(hello.host, wire::host_name());
  hello.pid = static_cast<std::uint32_t>(getpid());
  hello.threads = options_.threads;
  hello.evaluated = state_.evaluated;
  hello.leaving = state_.leaving;
  hello.cores = std::thread::hardware_concurrency();
  hello.golden = options_.golden;
  std::vector<coppice_wire_ChainId> chains;
  for (const ChainHash& hash : state_.chains.held()) {
    chains.push_back(wire::to_wire(hash));
  }
  hello.chains._buffer = chains.data();
  hello.chains._length = static_cast<std::uint32_t>(chains.size());
  hello.chains._maximum = hello.chains._length;
  hello.chains._release = false;
  if (auto ok = hellos_.write(hello); !ok) {
    spdlog::warn("could not say hello: {}", ok.error().message);
  }
}

// To those who watch.
void Server::say_alone() {
  if (options_.figures->waits()) {
    return;
  }
  options_.figures->wait_for(
      fmt::format("a coordinator at {} (UDP port {})", options_.coordinator, wire::coordinator_port(options_.domain)));
}

// Each lane finishes the individual that it is at.
void Server::stop_lanes() {
  state_.leave();
  for (const auto& lane : lanes_) {
    lane->wake();
  }
  lanes_.clear();
}

void Server::leave() {
  stop_lanes();
  tasks_.take(wire::kTaskDepth, [&](const wire::Task& task, const dds_sample_info_t& info) {
    if (info.valid_data) {
      give_back(state_, task, answers_);
    }
  });
  say_hello();
  answers_.wait_for_acknowledgements(kFarewellMs);
  hellos_.wait_for_acknowledgements(kFarewellMs);
}

}  // namespace

Result<void> serve(const ServeOptions& options, const StopFlag& stop) {
  WorkerState state;
  state.protocol = options.protocol;
  state.pace = options.pace;
  state.figures = options.figures;
  options.figures->lanes = options.threads;
  state.before_answer = options.before_answer;
  state.before_epoch_answer = options.before_epoch_answer;
  spdlog::info("worker {:016x} looks for a coordinator at {} in domain {} (UDP port {})", state.worker,
               options.coordinator, options.domain, wire::coordinator_port(options.domain));
  std::optional<ChainCache> cache;
  if (!options.cache.empty()) {
    auto opened = ChainCache::open(options.cache);
    if (!opened) {
      return tl::unexpected(opened.error());
    }
    cache.emplace(std::move(*opened));
  }
  Rest rest(stop);
  Absence absence(options);
  Clock::time_point next_complaint = Clock::time_point::min();
  while (!stop.raised()) {
    // A name belongs to the DDS participant that was first heard under it: another participant, another name.
    state.worker = wire::random_identity();
    auto server = Server::open(options, state, cache ? &*cache : nullptr);
    if (server) {
      next_complaint = Clock::time_point::min();
      options.figures->manager.ready();
      if (auto ok = (*server)->run(stop, absence); !ok) {
        return ok;
      }
      server->reset();  // its lanes with it
      state.come_back();
      continue;
    }
    // A host that is not up yet, a name that is not known yet, a network that is away: it may come.
    if (Clock::now() >= next_complaint) {
      next_complaint = Clock::now() + kComplainEvery;
      spdlog::warn("{}; trying again until it can be reached", server.error().message);
    }
    options.figures->turn();
    options.figures->wait_for(server.error().message);
    options.figures->manager.ready();  // it runs, and would be told otherwise to stop waiting
    rest.for_a_while(kRetry);
  }
  options.figures->manager.stopping();
  spdlog::info("leaves after {} individuals", state.evaluated.load());
  return {};
}

}  // namespace coppice
