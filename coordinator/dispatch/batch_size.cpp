#include "coordinator/dispatch/batch_size.hpp"

#include <algorithm>

#include "common/check.hpp"

namespace coppice {
namespace {

constexpr std::chrono::nanoseconds kGuess{std::chrono::microseconds(50)};  // an individual, before one was measured

std::uint64_t divide_up(std::uint64_t a, std::uint64_t b) { return (a + b - 1) / b; }

}  // namespace

std::uint32_t batch_size(const BatchRequest& request) {
  COPPICE_CHECK(request.waiting >= 1 && request.lanes >= 1);
  const auto each =
      static_cast<std::uint64_t>(std::max((request.each.count() > 0 ? request.each : kGuess).count(), std::int64_t{1}));
  const auto shortest = static_cast<std::uint64_t>(std::chrono::nanoseconds(kShortestBatch).count());
  const auto longest = static_cast<std::uint64_t>(std::chrono::nanoseconds(kLongestBatch).count());
  const std::uint64_t guided = divide_up(request.waiting, 2 * request.lanes);
  const std::uint64_t worthwhile = std::max(guided, divide_up(shortest, each));
  const std::uint64_t share = divide_up(request.waiting, request.lanes);
  const std::uint64_t size = std::min({worthwhile, share, std::max(longest / each, std::uint64_t{1})});
  return static_cast<std::uint32_t>(std::max(size, std::uint64_t{1}));
}

}  // namespace coppice
