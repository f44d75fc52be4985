#include "common/wire/waiter.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace coppice::wire {
namespace {

// What the waitset says when the entity wakes it.
enum class Cause : dds_attach_t { sample_or_wake = 0, matching = 1 };

constexpr std::size_t kMostCauses = 16;

Result<void> attach(dds_entity_t waitset, dds_entity_t entity, Cause cause) {
  if (const dds_return_t code = dds_waitset_attach(waitset, entity, static_cast<dds_attach_t>(cause));
      code != DDS_RETCODE_OK) {
    return failed(std::string("cannot attach to the DDS waitset: ") + dds_strretcode(-code));
  }
  return {};
}

}  // namespace

Result<Waiter> Waiter::make(const Participant& participant) {
  auto waitset = Entity::own(dds_create_waitset(participant.get()), "waitset");
  if (!waitset) {
    return tl::unexpected(waitset.error());
  }
  auto guard = Entity::own(dds_create_guardcondition(participant.get()), "guard condition");
  if (!guard) {
    return tl::unexpected(guard.error());
  }
  if (auto ok = attach(waitset->get(), guard->get(), Cause::sample_or_wake); !ok) {
    return tl::unexpected(ok.error());
  }
  return Waiter(std::move(*waitset), std::move(*guard));
}

Result<void> Waiter::watch_reader(dds_entity_t reader) {
  auto condition = Entity::own(dds_create_readcondition(reader, DDS_ANY_STATE), "read condition");
  if (!condition) {
    return tl::unexpected(condition.error());
  }
  auto ok = attach(waitset_.get(), condition->get(), Cause::sample_or_wake);
  conditions_.push_back(std::move(*condition));
  return ok;
}

Result<void> Waiter::watch_matching(dds_entity_t writer) {
  if (const dds_return_t code = dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS); code != DDS_RETCODE_OK) {
    return failed(std::string("cannot watch a DDS writer: ") + dds_strretcode(-code));
  }
  return attach(waitset_.get(), writer, Cause::matching);
}

bool Waiter::wait(std::chrono::nanoseconds timeout) {
  std::array<dds_attach_t, kMostCauses> causes{};
  const auto count =
      dds_waitset_wait(waitset_.get(), causes.data(), causes.size(), timeout.count() > 0 ? timeout.count() : 0);
  bool woken = false;
  dds_take_guardcondition(guard_.get(), &woken);
  const auto end = causes.begin() + std::clamp<std::ptrdiff_t>(count, 0, kMostCauses);
  return count > static_cast<std::int64_t>(kMostCauses) ||  // what was not told may be one
         std::find(causes.begin(), end, static_cast<dds_attach_t>(Cause::matching)) != end;
}

void Waiter::wake() const { dds_set_guardcondition(guard_.get(), true); }

}  // namespace coppice::wire
