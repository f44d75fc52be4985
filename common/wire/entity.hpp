// A DDS entity owned by value: deleted once, when its owner goes. Move-only.
#pragma once

#include <dds/dds.h>
#include <string>
#include <utility>

#include "common/error.hpp"

namespace coppice::wire {

class Entity {
 public:
  Entity() = default;
  // Takes over the handle that a dds_create_ function returned. Errors: it returned a failure.
  static Result<Entity> own(dds_entity_t handle, const std::string& what);

  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;
  ~Entity();

  dds_entity_t get() const { return handle_; }

 private:
  explicit Entity(dds_entity_t handle) : handle_(handle) {}

  dds_entity_t handle_ = 0;
};

}  // namespace coppice::wire
