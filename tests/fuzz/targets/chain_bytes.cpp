// chain_from_bytes(): whatever it accepts has exactly those bytes, and can be prepared, scored and walked, or is
// refused there.
#include "common/chain/chain_bytes.hpp"

#include <algorithm>
#include <memory>

#include "common/check.hpp"
#include "common/fitness/evaluation.hpp"
#include "tests/fuzz/target.hpp"

namespace coppice::fuzz {
namespace {

Job job_of(ObjectiveKind kind) {
  Job job;
  job.rollouts = 2;
  job.steps = 16;
  job.objectives = {Objective{kind, {}}};
  if (kind == ObjectiveKind::shaped) {
    job.objectives.front().rules = {ShapedRule{}};
  }
  return job;
}

// As a worker does with a chain that it was sent.
void use(Chain chain) {
  const std::size_t actions = chain.actions();
  const auto prepared = PreparedChain::make(std::make_shared<const Chain>(std::move(chain)));
  for (std::uint8_t kind = 0; kind < kObjectiveKinds; ++kind) {
    const auto job = PreparedJob::make(prepared, job_of(ObjectiveKind{kind}));
    if (!job) {
      COPPICE_CHECK(is_refusal(job.error()));
      continue;
    }
    const Tally tally = Evaluation(*job).evaluate(Tree(ActionId{static_cast<std::uint8_t>(actions - 1)}));
    COPPICE_CHECK(tally.matches <= tally.steps && tally.scores.size() == 1);
  }
}

void test(std::span<const std::uint8_t> bytes) {
  auto chain = chain_from_bytes(bytes);
  accepted = chain.has_value();
  if (!chain) {
    COPPICE_CHECK(is_refusal(chain.error()));
    return;
  }
  const auto encoded = to_bytes(*chain);
  COPPICE_CHECK(std::equal(encoded.begin(), encoded.end(), bytes.begin(), bytes.end()));
  COPPICE_CHECK(chain_hash_from_hex(hash_of(bytes).hex()) == hash_of(encoded));
  use(std::move(*chain));
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test({data, size});
  return 0;
}
