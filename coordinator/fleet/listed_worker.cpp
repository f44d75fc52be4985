#include "coordinator/fleet/listed_worker.hpp"

#include <fmt/format.h>
#include <utility>

namespace coppice {
namespace {

std::string doing_of(const wire::WorkerStatus& status) {
  switch (status.doing) {
    case coppice_wire_FETCHING:
      return "fetching the chain";
    case coppice_wire_READY:
      return "ready";
    case coppice_wire_EVALUATING:
      return fmt::format("evaluating, {} batch{} in hand", status.batches, status.batches == 1 ? "" : "es");
    case coppice_wire_REFUSED_VERSION:
      return "refused: another protocol version";
    case coppice_wire_QUARANTINED:
      return "quarantined: answered wrongly";
    case coppice_wire_REFUSED_BUILD:
      return "refused: another build, which computes otherwise";
  }
  return "unknown";
}

}  // namespace

ListedWorker listed(const wire::WorkerStatus& status, std::string doing) {
  return {.host = wire::shown(status.host),
          .pid = status.pid,
          .cores = status.cores,
          .threads = status.threads,
          .protocol = status.protocol,
          .version = wire::shown(status.version),
          .doing = std::move(doing),
          .evaluated = status.evaluated,
          .each_second = status.each_second,
          .seen = std::chrono::milliseconds(status.seen_ms)};
}

ListedWorker listed(const wire::WorkerStatus& status) { return listed(status, doing_of(status)); }

}  // namespace coppice
