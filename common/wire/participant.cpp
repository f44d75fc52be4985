#include "common/wire/participant.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <dds/ddsrt/log.h>
#include <fmt/format.h>
#include <mutex>
#include <string>

#include "common/wire/short_turns.hpp"

namespace coppice::wire {
namespace {

// libddsc calls the sink from any of its threads.
struct DdsLog {
  std::mutex mutex;
  void (*sink)(const char*) = nullptr;
  std::chrono::steady_clock::time_point second;
  int lines_in_second = 0;
  std::string joining;  // while join() runs: what was said, for its error
  bool is_joining = false;
};

DdsLog& dds_log() {
  static DdsLog log;
  return log;
}

void take_line(void*, const dds_log_data_t* data) {
  DdsLog& log = dds_log();
  const std::lock_guard lock(log.mutex);
  std::string line(data->message, data->size);
  while (!line.empty() && (line.back() == '\n' || line.back() == ' ')) {
    line.pop_back();
  }
  if (log.is_joining) {
    log.joining += (log.joining.empty() ? "" : "; ") + line;
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (now - log.second > std::chrono::seconds(1)) {
    log.second = now;
    log.lines_in_second = 0;
  }
  if (log.sink != nullptr && ++log.lines_in_second <= kMaxDdsLinesPerSecond) {
    log.sink(line.c_str());
  }
}

// Without this libddsc prints to standard error itself.
void install_sinks() {
  dds_set_log_sink(&take_line, nullptr);
  dds_set_trace_sink(&take_line, nullptr);
}

std::string set_joining(bool joining) {
  DdsLog& log = dds_log();
  const std::lock_guard lock(log.mutex);
  log.is_joining = joining;
  return std::exchange(log.joining, {});
}

}  // namespace

void route_dds_log(void (*sink)(const char* line)) {
  {
    const std::lock_guard lock(dds_log().mutex);
    dds_log().sink = sink;
  }
  install_sinks();
}

Result<Participant> Participant::join(std::uint32_t domain, const std::string& configuration) {
  install_sinks();
  set_joining(true);
  const ShortTurns turns;  // of DDS's threads, which are started here
  Entity owned_domain;
  const char* uri = std::getenv("CYCLONEDDS_URI");
  if (uri == nullptr || *uri == '\0') {
    auto created = Entity::own(dds_create_domain(domain, configuration.c_str()), fmt::format("domain {}", domain));
    if (!created) {
      const std::string why = set_joining(false);
      return why.empty() ? tl::unexpected(created.error()) : in_context(why, created.error());
    }
    owned_domain = std::move(*created);
  }
  auto participant =
      Entity::own(dds_create_participant(domain, nullptr, nullptr), fmt::format("participant in domain {}", domain));
  const std::string said = set_joining(false);
  if (!participant) {
    return said.empty() ? tl::unexpected(participant.error()) : in_context(said, participant.error());
  }
  return Participant(std::move(owned_domain), std::move(*participant));
}

std::size_t Participant::others() const {
  constexpr std::size_t kMost = 64;
  const auto reader = Entity::own(
      dds_create_reader(participant_.get(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr), "participants");
  if (!reader) {
    return 0;
  }
  std::array<void*, kMost> samples{};
  std::array<dds_sample_info_t, kMost> infos;
  const dds_return_t count = dds_read(reader->get(), samples.data(), infos.data(), kMost, kMost);
  std::size_t alive = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
    alive += infos[i].valid_data && infos[i].instance_state == DDS_ALIVE_INSTANCE_STATE ? 1 : 0;
  }
  if (count > 0) {
    dds_return_loan(reader->get(), samples.data(), count);
  }
  return alive > 0 ? alive - 1 : 0;  // it is one of them itself
}

}  // namespace coppice::wire
