// Who wrote a sample: the DDS participant behind its writer. A worker says in its samples who it is; anybody else could
// say the same. The participant is what DDS vouches for (under DDS Security by certificate), so a name belongs to the
// participant that was first heard under it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <dds/dds.h>
#include <optional>
#include <unordered_map>

namespace coppice::wire {

using Origin = std::array<std::uint8_t, 16>;  // the participant's GUID

// Remembers writers, which asking DDS about takes a few microseconds each time. Belongs to one thread.
class Origins {
 public:
  // Of a sample that `reader` took. Empty: its writer is gone, and was never asked about before.
  std::optional<Origin> of(dds_entity_t reader, const dds_sample_info_t& info);

 private:
  std::unordered_map<dds_instance_handle_t, Origin> known_;  // by writer; DDS never uses a handle twice
};

}  // namespace coppice::wire
