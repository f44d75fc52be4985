// EpochDecoder::decode_task(): whatever it accepts encodes to the same bytes, and a worker runs it or refuses it; its
// result travels back as it is.
#include <algorithm>
#include <memory>

#include "common/check.hpp"
#include "common/wire/epoch_codec.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

// What takes long and reaches nothing new is decoded, not run.
constexpr std::uint64_t kMostWalked = 4096;  // steps of a tree
constexpr std::size_t kMostIndividuals = 64;
constexpr std::uint32_t kMostGenerations = 4;
constexpr std::uint32_t kMostNodes = 60;
constexpr std::uint32_t kMostClimbed = 4;  // edits of a guided climb

bool is_cheap(const EvolveConfig& config, const EpochTask& task) {
  const std::uint32_t begin = task.deme ? task.deme->generations : 0;
  const GaConfig& ga = config.ga;
  return task.until - begin <= kMostGenerations && ga.population <= kMostIndividuals && ga.max_nodes <= kMostNodes &&
         ga.max_depth <= 16 && ga.max_children <= kMostNodes && (ga.guided == 0.0 || ga.guided_steps <= kMostClimbed) &&
         std::uint64_t{config.rollout.rollouts} * config.rollout.steps <= kMostWalked;
}

void run(const wire::DecodedEpoch& epoch, const std::shared_ptr<const Chain>& chain, wire::EpochDecoder& decoder) {
  static const auto prepared = PreparedChain::make(chain);
  if (!is_cheap(*epoch.config, epoch.task)) {
    return;
  }
  EpochRunner runner(prepared);
  const auto result = runner.run(*epoch.config, epoch.task, [](std::size_t) { return true; });
  if (!result) {
    COPPICE_CHECK(is_refusal(result.error()));
    return;
  }
  const auto answer = decoder.decode_result(wire::encode_epoch_result(*result), epoch.config, epoch.task);
  COPPICE_CHECK(answer.has_value() && *answer == *result);
}

void test(std::span<const std::uint8_t> bytes) {
  static const auto chain = std::make_shared<const Chain>(small_chain());
  wire::EpochDecoder decoder(*chain);
  const auto epoch = decoder.decode_task(bytes);
  accepted = epoch.has_value();
  if (!epoch) {
    COPPICE_CHECK(is_refusal(epoch.error()));
    return;
  }
  COPPICE_CHECK(check_search(*epoch->config, chain->vocabulary()).has_value());
  COPPICE_CHECK(EpochCheck(*chain, *epoch->config).task(epoch->task).has_value());
  const auto configuration = wire::encode_configuration(*epoch->config, epoch->task.deme == nullptr);
  const auto encoded = wire::encode_epoch_task(configuration, epoch->task);
  COPPICE_CHECK(std::equal(encoded.begin(), encoded.end(), bytes.begin(), bytes.end()));
  run(*epoch, chain, decoder);
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test({data, size});
  return 0;
}
