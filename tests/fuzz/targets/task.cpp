// TaskDecoder: whatever it accepts encodes to the same bytes, passed the checks that its header promises, and can be
// prepared and evaluated by a worker, or is refused there.
#include <algorithm>
#include <memory>

#include "common/check.hpp"
#include "common/fitness/evaluation.hpp"
#include "common/wire/codec.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/fuzz/words.hpp"

namespace coppice::fuzz {
namespace {

constexpr std::uint64_t kMaxWalked = 4096;  // steps; more take long and reach nothing new
constexpr std::size_t kMaxEvaluated = 8;    // trees of a task

std::shared_ptr<const PreparedChain> prepared_chain() {
  return PreparedChain::make(std::make_shared<const Chain>(small_chain()));
}

void evaluate(const wire::DecodedTask& task) {
  static const auto chain = prepared_chain();
  if (std::uint64_t{task.job.rollouts} * task.job.steps > kMaxWalked) {
    return;
  }
  const auto job = PreparedJob::make(chain, task.job);
  if (!job) {
    COPPICE_CHECK(is_refusal(job.error()));
    return;
  }
  Evaluation evaluation(*job);
  for (std::size_t i = 0; i < std::min(task.trees.size(), kMaxEvaluated); ++i) {
    const Tally tally = evaluation.evaluate(task.trees[i]);
    COPPICE_CHECK(tally.nodes == task.trees[i].size() && tally.matches <= tally.steps);
    COPPICE_CHECK(tally.scores.size() == task.job.objectives.size());
    COPPICE_CHECK(tally == evaluation.evaluate(task.trees[i]));
  }
}

void test(std::span<const std::uint8_t> bytes) {
  const auto task = wire::TaskDecoder(words()).decode(bytes);
  accepted = task.has_value();
  if (!task) {
    COPPICE_CHECK(is_printable_refusal(task.error()));
    return;
  }
  COPPICE_CHECK(check_job(task->job).has_value());
  for (const Tree& tree : task->trees) {
    COPPICE_CHECK(check_tree(tree, words()).has_value());
  }
  const auto encoded = wire::encode_task(task->job, task->trees);
  COPPICE_CHECK(std::equal(encoded.begin(), encoded.end(), bytes.begin(), bytes.end()));
  evaluate(*task);
}

}  // namespace
}  // namespace coppice::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::fuzz::test({data, size});
  return 0;
}
