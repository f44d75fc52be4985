// decode_tallies(): whatever it accepts is what was asked for, and encodes to the same bytes. The first two bytes of an
// input are how many trees and objectives the receiver had asked about; the rest is the payload.
#include <algorithm>

#include "common/check.hpp"
#include "common/wire/codec.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

constexpr std::size_t kAsked = 2;  // bytes

void test(std::span<const std::uint8_t> input) {
  if (input.size() < kAsked) {
    return;
  }
  const std::size_t trees = input[0];
  const std::size_t objectives = input[1] % (kMaxObjectives + 1);
  const auto payload = input.subspan(kAsked);
  const auto tallies = wire::decode_tallies(payload, trees, objectives);
  accepted = tallies.has_value();
  if (!tallies) {
    COPPICE_CHECK(is_printable_refusal(tallies.error()));
    return;
  }
  COPPICE_CHECK(tallies->size() == trees);
  for (const Tally& tally : *tallies) {
    COPPICE_CHECK(tally.scores.size() == objectives);
  }
  const auto encoded = wire::encode_tallies(*tallies);
  COPPICE_CHECK(std::equal(encoded.begin(), encoded.end(), payload.begin(), payload.end()));
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test({data, size});
  return 0;
}
