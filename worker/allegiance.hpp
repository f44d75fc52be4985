// Which coordinator a worker serves: whoever announces a run that it can take part in, the last one if there are
// several, until that one is gone. Anybody who reaches the worker's port may announce something else, or dispose of
// what another announced, and DDS delivers it; so only the writer that announced the run can end it. A run of another
// version or build stops the worker when nobody else is there to be served. Pure but for the reader; time is passed in.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "common/wire/topics.hpp"

namespace coppice {

class Allegiance {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // For a run that suits, which so long does not come, before the worker gives up over one that does not.
  static constexpr std::chrono::milliseconds kPatience{1000};

  // What this worker speaks and computes. `controls` outlives it.
  struct Self {
    std::uint32_t protocol = 0;
    std::uint64_t golden = 0;
    std::string version;
  };
  Allegiance(const wire::Reader<wire::Control>& controls, Self self) : controls_(controls), self_(std::move(self)) {}

  // Takes what was announced. `serve` is called with each announcement that suits; `part` when the coordinator that was
  // served is gone.
  void listen(Time now, const std::function<void(const wire::Control&)>& serve, const std::function<void()>& part);
  // Why the worker can serve nobody, for whoever started it; empty: it can, or may soon.
  std::optional<std::string> refusal(Time now) const;

 private:
  std::optional<std::string> objection(const wire::Control& control) const;
  void object(const std::string& why, dds_instance_handle_t writer, Time now);
  bool is_there(dds_instance_handle_t writer) const;

  const wire::Reader<wire::Control>& controls_;
  Self self_;
  std::optional<dds_instance_handle_t> served_;  // the writer of the run's announcement
  std::optional<std::string> refusal_;
  Time refused_since_{};
  std::set<dds_instance_handle_t> objected_;  // writers, said once
};

}  // namespace coppice
