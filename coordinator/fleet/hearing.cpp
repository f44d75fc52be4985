// What happens, turned into events. Only samples with data count: anybody may dispose of a worker's Hello, or
// unregister it, and DDS does not say who did; that a worker is gone shows in its silence.
#include <algorithm>
#include <fmt/format.h>
#include <unistd.h>

#include "coordinator/fleet/fleet.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMostHeard = 1024;
constexpr std::ptrdiff_t kMostReason = 200;  // characters of a worker's reason that are logged

}  // namespace

bool Fleet::is_ours(std::uint32_t protocol, std::uint64_t run_id, const coppice_wire_ChainId& chain) const {
  return protocol == wire::kProtocolVersion && run_id == run_.run_id && wire::from_wire(chain) == run_.chain;
}

void Fleet::listen() {
  dds_.hellos.take(kMostHeard, [this](const wire::Hello& hello, const dds_sample_info_t& info) { hear(hello, info); });
  dds_.requests.take(kMostHeard,
                     [this](const wire::ChainRequest& request, const dds_sample_info_t& info) { hear(request, info); });
  dds_.answers.take(kMostHeard,
                    [this](const wire::Answer& answer, const dds_sample_info_t& info) { hear(answer, info); });
  if (local_) {
    for (LocalWorkers::Ended& ended : local_->reap()) {
      events_.emplace_back(ProcessEnded{ended.place, ended.pid, ended.in_order, std::move(ended.how)});
    }
  }
  for (auto entry = apart_.begin(); entry != apart_.end();) {
    const auto work = works_.find(entry->second->request());
    if (auto ended = entry->second->take_ended(); ended) {
      Computed computed{entry->first, ended->elapsed, {}, std::move(ended->died)};
      if (computed.died.empty() && work != works_.end()) {
        if (auto outcomes = work->second->decode(ended->answer, entry->second->unit(), 1)) {
          computed.outcomes = std::move(*outcomes);
        } else {
          computed.died = outcomes.error().message;
        }
      }
      events_.emplace_back(std::move(computed));
      entry = apart_.erase(entry);
    } else {
      ++entry;
    }
  }
  look_at_links();
}

void Fleet::hear(const wire::Hello& hello, const dds_sample_info_t& info) {
  if (!info.valid_data) {
    return;
  }
  HelloHeard heard;
  heard.worker = WorkerId{hello.worker};
  heard.origin = dds_.origins.of(dds_.hellos.get(), info);
  const auto speaker = dispatcher_.roster().speaker(heard.worker, heard.origin);
  if (speaker == Roster::Speaker::own || speaker == Roster::Speaker::first) {
    onlookers_.hear(hello, Clock::now());
  }
  heard.name = fmt::format("{}, pid {}", wire::shown(hello.host), hello.pid);
  heard.version = wire::shown(hello.version);
  heard.protocol = hello.protocol;
  heard.golden = hello.golden;
  heard.pid = static_cast<pid_t>(hello.pid);
  heard.here = local_.has_value() && hello.host == wire::host_name();
  heard.lanes = hello.threads;
  heard.evaluated = hello.evaluated;
  heard.leaving = hello.leaving;
  heard.serves = hello.run_id == run_.run_id;
  const std::span<const coppice_wire_ChainId> held(hello.chains._buffer, hello.chains._length);
  heard.holds_chain = heard.serves && std::any_of(held.begin(), held.end(), [&](const coppice_wire_ChainId& id) {
                        return wire::from_wire(id) == run_.chain;
                      });
  events_.emplace_back(std::move(heard));
}

void Fleet::hear(const wire::ChainRequest& request, const dds_sample_info_t& info) {
  if (!info.valid_data) {
    return;
  }
  if (!is_ours(request.protocol, request.run_id, request.chain)) {
    events_.emplace_back(NonsenseHeard{WorkerId{request.worker}, "a request for a chain that this run does not hold"});
    return;
  }
  events_.emplace_back(
      BlocksAsked{WorkerId{request.worker}, dds_.origins.of(dds_.requests.get(), info), request.first, request.count});
}

void Fleet::hear(const wire::Answer& answer, const dds_sample_info_t& info) {
  if (!info.valid_data) {
    return;
  }
  if (!is_ours(answer.protocol, answer.run_id, answer.chain)) {
    events_.emplace_back(NonsenseHeard{WorkerId{answer.worker}, "an answer of another run"});
    return;
  }
  AnswerHeard heard;
  heard.worker = WorkerId{answer.worker};
  heard.origin = dds_.origins.of(dds_.answers.get(), info);
  heard.batch = BatchId{answer.batch};
  heard.elapsed =
      std::chrono::nanoseconds(std::min<std::uint64_t>(answer.elapsed_ns, std::numeric_limits<std::int64_t>::max()));
  heard.repeated = answer.repeated;
  heard.bytes = answer.payload._length;
  decode(answer, heard);
  events_.emplace_back(std::move(heard));
}

void Fleet::decode(const wire::Answer& answer, AnswerHeard& heard) const {
  using Kind = AnswerHeard::Kind;
  switch (answer.outcome) {
    case coppice_wire_GIVEN_BACK:
      heard.kind = Kind::given_back;
      return;
    case coppice_wire_NO_MEMORY:
      heard.kind = Kind::no_memory;
      return;
    case coppice_wire_CHAIN_UNKNOWN:
      heard.kind = Kind::chain_unknown;
      return;
    case coppice_wire_REFUSED: {
      heard.kind = Kind::refused;
      const auto text = wire::view(answer.payload);
      const std::string reason(text.begin(), text.begin() + std::min(std::ssize(text), kMostReason));
      heard.text = wire::shown(reason.c_str());
      return;
    }
    case coppice_wire_EVALUATED:
      break;
  }
  heard.kind = Kind::computed;
  const auto out = dispatcher_.find(heard.batch, heard.worker);
  if (!dispatcher_.listens_to(heard.worker, heard.origin) || !out || !out->current) {
    return;
  }
  auto outcomes = works_.at(out->batch.request)->decode(wire::view(answer.payload), out->batch.first, out->batch.count);
  if (outcomes) {
    heard.outcomes = std::move(*outcomes);
  } else {
    heard.kind = Kind::damaged;
    heard.text = outcomes.error().message;
  }
}

void Fleet::look_at_links() {
  const auto now = Clock::now();
  settling_ = false;
  for (auto& [id, link] : links_) {
    if ((matching_changed_ || !link.settled()) && link.look(now)) {
      events_.emplace_back(LinkChanged{id, link.settled()});
    }
    settling_ = settling_ || link.settling();
    link.send_blocks(chain_bytes_, run_);
  }
}

}  // namespace coppice
