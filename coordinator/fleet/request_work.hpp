// What a request is made of, for whoever carries out the dispatcher's actions: units of one kind, seen in portions so
// that the first are under way meanwhile; how they travel, and how they are computed here. To dispatch another kind of
// work, implement this, and teach the worker's lanes the other side. Belongs to the thread of its Fleet.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "coordinator/dispatch/requests.hpp"
#include "coordinator/dispatch/work.hpp"

namespace coppice {

class RequestWork {
 public:
  RequestWork() = default;
  RequestWork(const RequestWork&) = delete;
  RequestWork& operator=(const RequestWork&) = delete;
  virtual ~RequestWork() = default;

  virtual RequestTerms terms() const = 0;
  // Looks at the next portion. Returns how many units there are more.
  virtual std::uint32_t look_up_portion() = 0;
  virtual bool all_seen() const = 0;

  // The payload of a task with these units. REQUIRES: count <= terms().most_per_batch, but 1 always fits.
  virtual std::vector<std::uint8_t> encode(std::uint32_t first, std::uint32_t count) const = 0;
  // The outcomes in a worker's answer to encode(first, count). Errors: it cannot be an answer to that.
  virtual Result<std::vector<UnitOutcome>> decode(std::span<const std::uint8_t> payload, std::uint32_t first,
                                                  std::uint32_t count) const = 0;
  // Computes these units here: the truth. Errors: interrupted.
  virtual Result<std::vector<UnitOutcome>> compute(std::span<const std::uint32_t> units) = 0;
  // For a message about a unit that ends processes: what it is, and the command that shows it again.
  virtual std::string in_words(std::uint32_t unit) const = 0;
};

}  // namespace coppice
