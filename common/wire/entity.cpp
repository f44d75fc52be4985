#include "common/wire/entity.hpp"

#include <fmt/format.h>

namespace coppice::wire {

Result<Entity> Entity::own(dds_entity_t handle, const std::string& what) {
  if (handle < 0) {
    return failed(fmt::format("cannot create DDS {}: {}", what, dds_strretcode(-handle)));
  }
  return Entity(handle);
}

Entity::~Entity() {
  if (handle_ > 0) {
    dds_delete(handle_);
  }
}

}  // namespace coppice::wire
