// EpochDecoder::decode_result(): whatever it accepts is a result that the task can have, and encodes to the same bytes.
// The first byte of an input says which of the sample epochs was asked for; the rest is the payload.
#include <algorithm>

#include "common/check.hpp"
#include "common/wire/epoch_codec.hpp"
#include "tests/fuzz/epochs.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

void test(std::span<const std::uint8_t> input) {
  static const Chain chain = small_chain();
  static wire::EpochDecoder decoder(chain);
  if (input.empty()) {
    return;
  }
  const SampleEpoch asked = sample_epoch(input.front() % kSampleEpochs, chain);
  const auto payload = input.subspan(1);
  const auto result = decoder.decode_result(payload, asked.config, asked.task);
  accepted = result.has_value();
  if (!result) {
    COPPICE_CHECK(is_refusal(result.error()));
    return;
  }
  COPPICE_CHECK(EpochCheck(chain, *asked.config).result(*result, asked.task).has_value());
  const auto encoded = wire::encode_epoch_result(*result);
  COPPICE_CHECK(std::equal(encoded.begin(), encoded.end(), payload.begin(), payload.end()));
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test({data, size});
  return 0;
}
