#include "common/fitness/golden_job.hpp"

#include <cstring>
#include <string>
#include <vector>
#include <xxhash.h>

#include "common/chain/exact.hpp"
#include "common/chain/random.hpp"
#include "common/check.hpp"
#include "common/fitness/evaluation.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/random_tree.hpp"

namespace coppice {
namespace {

constexpr std::uint64_t kSeed = 2016;
constexpr std::uint32_t kStates = 81;  // four features of three values
constexpr std::uint32_t kFeatures = 4;
constexpr std::uint32_t kActions = 3;
constexpr std::uint32_t kMaxSuccessors = 6;
constexpr std::size_t kTrees = 12;
constexpr std::uint32_t kSteps = 60;
constexpr double kGamma = 0.97;

class Bits {
 public:
  template <typename Value>
  void add(const Value& value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(value));
    std::memcpy(bytes_.data() + at, &value, sizeof(value));
  }
  std::uint64_t hash() const { return XXH3_64bits(bytes_.data(), bytes_.size()); }

 private:
  std::vector<std::uint8_t> bytes_;
};

Chain golden_chain() {
  Xoshiro256 random(kSeed);
  ChainParts parts;
  for (std::uint32_t feature = 0; feature < kFeatures; ++feature) {
    parts.vocabulary.features.push_back({"f" + std::to_string(feature), {0, 1, 3}, true, true});
  }
  for (std::uint32_t action = 0; action < kActions; ++action) {
    parts.vocabulary.actions.push_back("a" + std::to_string(action));
  }
  parts.row_begin = {0};
  for (std::uint32_t state = 0; state < kStates; ++state) {
    for (std::uint32_t feature = 0, rest = state; feature < kFeatures; ++feature, rest /= 3) {
      parts.features.push_back(parts.vocabulary.features[feature].values[rest % 3]);
    }
    parts.visits.push_back(random.below(1000));
    for (std::uint32_t action = 0; action < kActions; ++action) {
      // Ascending successors; one pair in ten was never tried, as in chains that were counted.
      const std::uint64_t wanted = random.below(10) == 0 ? 0 : 1 + random.below(kMaxSuccessors);
      std::uint32_t tries = 0;
      for (std::uint64_t i = 0, next = random.below(kStates / kMaxSuccessors); i < wanted; ++i) {
        parts.successor.push_back(static_cast<std::uint32_t>(next));
        parts.count.push_back(static_cast<std::uint32_t>(1 + random.below(1000)));
        tries += parts.count.back();
        next += 1 + random.below(kStates / kMaxSuccessors - 1);
      }
      parts.row_begin.push_back(parts.successor.size());
      parts.reward_sum.push_back(tries * (static_cast<double>(random.below(201)) - 100) / 7);
      parts.q.push_back((static_cast<double>(random.below(2001)) - 1000) / 77);
    }
  }
  parts.policy = greedy_policy(parts.q, kActions);
  auto chain = Chain::make(std::move(parts));
  COPPICE_CHECK(chain.has_value());
  return std::move(*chain);
}

void add_tallies(const std::shared_ptr<const PreparedChain>& chain, const std::vector<Tree>& trees, Simd simd,
                 Bits& bits) {
  for (const Acting acting : {Acting::tree, Acting::policy, Acting::mixed}) {
    for (const Method method : {Method::rollouts, Method::exact, Method::discounted, Method::long_run}) {
      Job job;
      job.objectives = {{ObjectiveKind::agreement},
                        {ObjectiveKind::coverage},
                        {ObjectiveKind::expected_return},
                        {ObjectiveKind::regret},
                        {ObjectiveKind::unknown}};
      job.steps = kSteps;
      job.acting = acting;
      job.policy_share = acting == Acting::mixed ? std::uint64_t{1} << 62U : 0;
      job.method = method;
      job.gamma = method == Method::discounted ? fixed_point_share(kGamma) : 0;
      job.seed = kSeed;
      const auto prepared = PreparedJob::make(chain, job);
      COPPICE_CHECK(prepared.has_value());
      for (const Tally& tally : Evaluation(*prepared, simd).evaluate(trees)) {
        bits.add(tally.matches);
        bits.add(tally.steps);
        for (const std::int64_t score : tally.scores) {
          bits.add(score);
        }
      }
    }
  }
}

void add(const Occupancy* occupancy, Bits& bits) {
  COPPICE_CHECK(occupancy != nullptr);
  for (std::size_t i = 0; i < occupancy->states.size(); ++i) {
    bits.add(occupancy->states[i]);
    bits.add(occupancy->visits[i]);
  }
}

void add_occupancies(const PreparedChain& chain, const std::vector<Tree>& trees, Simd simd, Bits& bits) {
  ExactOccupancy exact(chain.chain());
  std::vector<std::uint8_t> actions(kStates);
  for (const Tree& tree : trees) {
    fill_action_table(tree, chain.columns(), kActions, actions, simd);
    const ActingTables acting{.actions = actions, .others = {}};
    add(&exact.over_steps(acting, kSteps), bits);
    add(exact.discounted(acting, kGamma), bits);
    add(exact.long_run(acting), bits);
  }
}

}  // namespace

std::uint64_t compute_golden_checksum(Simd simd) {
  const auto chain = PreparedChain::make(std::make_shared<const Chain>(golden_chain()));
  Stream stream(kSeed, Purpose::growing, 0, 0);
  std::vector<Tree> trees;
  trees.reserve(kTrees);
  for (std::size_t i = 0; i < kTrees; ++i) {
    trees.push_back(grow_tree(chain->chain().vocabulary(), {.max_depth = 4}, true,
                              [&](std::uint64_t n) { return stream.below(n); }));
  }
  Bits bits;
  add_tallies(chain, trees, simd, bits);
  add_occupancies(*chain, trees, simd, bits);
  return bits.hash() == 0 ? 1 : bits.hash();
}

std::uint64_t golden_checksum() {
  static const std::uint64_t checksum = compute_golden_checksum(best_simd());
  return checksum;
}

}  // namespace coppice
