#include "common/wire/origin.hpp"

#include <algorithm>
#include <iterator>
#include <memory>

namespace coppice::wire {
namespace {

constexpr std::size_t kMostKnown = 8192;  // several for each worker; those that are still there are soon known again

}  // namespace

std::optional<Origin> Origins::of(dds_entity_t reader, const dds_sample_info_t& info) {
  if (const auto found = known_.find(info.publication_handle); found != known_.end()) {
    return found->second;
  }
  const std::unique_ptr<dds_builtintopic_endpoint_t, decltype(&dds_builtintopic_free_endpoint)> writer(
      dds_get_matched_publication_data(reader, info.publication_handle), &dds_builtintopic_free_endpoint);
  if (!writer) {
    return std::nullopt;
  }
  if (known_.size() >= kMostKnown) {
    known_.clear();
  }
  Origin origin{};
  static_assert(sizeof writer->participant_key.v == sizeof(Origin));
  std::copy(std::begin(writer->participant_key.v), std::end(writer->participant_key.v), origin.begin());
  known_.emplace(info.publication_handle, origin);
  return origin;
}

}  // namespace coppice::wire
