#include "worker/epochs.hpp"

namespace coppice {

Result<std::vector<std::uint8_t>> Epochs::run(std::span<const std::uint8_t> payload,
                                              const std::function<bool(std::size_t)>& go_on,
                                              const std::function<void(EpochResult&)>& before_answer) {
  const auto epoch = decoder_.decode_task(payload);
  if (!epoch) {
    return tl::unexpected(epoch.error());
  }
  auto result = runner_.run(*epoch->config, epoch->task, go_on);
  if (!result) {
    return tl::unexpected(result.error());
  }
  if (before_answer) {
    before_answer(*result);
  }
  return wire::encode_epoch_result(*result);
}

}  // namespace coppice
