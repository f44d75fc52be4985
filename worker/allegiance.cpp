#include "worker/allegiance.hpp"

#include <fmt/format.h>
#include <memory>
#include <spdlog/spdlog.h>
#include <utility>

namespace coppice {
namespace {

constexpr std::size_t kMostPerLook = 256;
constexpr std::size_t kMostObjected = 256;  // writers that are remembered

}  // namespace

bool Allegiance::is_there(dds_instance_handle_t writer) const {
  const std::unique_ptr<dds_builtintopic_endpoint_t, decltype(&dds_builtintopic_free_endpoint)> found(
      dds_get_matched_publication_data(controls_.get(), writer), &dds_builtintopic_free_endpoint);
  return found != nullptr;
}

std::optional<std::string> Allegiance::objection(const wire::Control& control) const {
  const auto coordinator = [&] {
    return fmt::format("the coordinator {} (pid {}, version {})", wire::shown(control.host), control.pid,
                       wire::shown(control.version));
  };
  if (control.protocol != self_.protocol) {
    return fmt::format(
        "{} speaks protocol {}, this worker (version {}) speaks {}: install the same version of Coppice on both",
        coordinator(), control.protocol, self_.version, self_.protocol);
  }
  if (control.golden != self_.golden) {
    return fmt::format(
        "{} computes otherwise than this worker (version {}): the golden job gives {:016x} there and {:016x} here; "
        "install the same build of Coppice on both",
        coordinator(), self_.version, control.golden, self_.golden);
  }
  return std::nullopt;
}

void Allegiance::object(const std::string& why, dds_instance_handle_t writer, Time now) {
  if (!served_) {
    refused_since_ = refusal_ ? refused_since_ : now;
    refusal_ = why;
  } else if (objected_.size() < kMostObjected && objected_.insert(writer).second) {
    spdlog::warn("{}; it is ignored, since another is served", why);
  }
}

void Allegiance::listen(Time now, const std::function<void(const wire::Control&)>& serve,
                        const std::function<void()>& part) {
  const auto gone = [&] {
    served_.reset();
    part();
  };
  controls_.take(kMostPerLook, [&](const wire::Control& control, const dds_sample_info_t& info) {
    if (!info.valid_data) {
      // Anybody can dispose of the announcement; that nobody writes it any more, nobody can pretend.
      if (served_ &&
          (info.instance_state == DDS_NOT_ALIVE_NO_WRITERS_INSTANCE_STATE ||
           (info.instance_state == DDS_NOT_ALIVE_DISPOSED_INSTANCE_STATE && served_ == info.publication_handle))) {
        gone();
      }
      return;
    }
    if (const auto why = objection(control)) {
      object(*why, info.publication_handle, now);
      return;
    }
    served_ = info.publication_handle;
    refusal_.reset();
    serve(control);
  });
  if (served_ && !is_there(*served_)) {
    gone();
  }
}

std::optional<std::string> Allegiance::refusal(Time now) const {
  return !served_ && refusal_ && now - refused_since_ >= kPatience ? refusal_ : std::nullopt;
}

}  // namespace coppice
