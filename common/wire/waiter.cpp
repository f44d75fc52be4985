#include "common/wire/waiter.hpp"

#include <string>

namespace coppice::wire {
namespace {

Result<void> attach(dds_entity_t waitset, dds_entity_t entity) {
  if (const dds_return_t code = dds_waitset_attach(waitset, entity, 0); code != DDS_RETCODE_OK) {
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
  if (auto ok = attach(waitset->get(), guard->get()); !ok) {
    return tl::unexpected(ok.error());
  }
  return Waiter(std::move(*waitset), std::move(*guard));
}

Result<void> Waiter::watch_reader(dds_entity_t reader) {
  auto condition = Entity::own(dds_create_readcondition(reader, DDS_ANY_STATE), "read condition");
  if (!condition) {
    return tl::unexpected(condition.error());
  }
  auto ok = attach(waitset_.get(), condition->get());
  conditions_.push_back(std::move(*condition));
  return ok;
}

Result<void> Waiter::watch_matching(dds_entity_t writer) {
  if (const dds_return_t code = dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS); code != DDS_RETCODE_OK) {
    return failed(std::string("cannot watch a DDS writer: ") + dds_strretcode(-code));
  }
  return attach(waitset_.get(), writer);
}

void Waiter::wait(std::chrono::nanoseconds timeout) {
  dds_waitset_wait(waitset_.get(), nullptr, 0, timeout.count() > 0 ? timeout.count() : 0);
  bool woken = false;
  dds_take_guardcondition(guard_.get(), &woken);
}

void Waiter::wake() const { dds_set_guardcondition(guard_.get(), true); }

}  // namespace coppice::wire
