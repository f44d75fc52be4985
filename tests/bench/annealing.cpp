// How many states can a tree of so many nodes agree with? Simulated annealing with the same edits as evolution's, for
// as long as one likes: an answer that owes nothing to populations, to hold theirs against.
//   annealing STUDY NODES SEED STEPS
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <string_view>

#include "common/chain/random.hpp"
#include "common/evolution/breeding.hpp"
#include "common/tree/action_table.hpp"
#include "common/tree/text.hpp"
#include "coordinator/study/study.hpp"

namespace coppice {
namespace {

constexpr double kHot = 12.0;        // states that a change may lose, at the beginning
constexpr double kCold = 0.4;        // and at the end
constexpr std::uint64_t kBold = 20;  // one change in so many replaces a subtree

class Coverage {
 public:
  explicit Coverage(const Chain& chain)
      : columns_(chain.vocabulary(), chain.parts().features), actions_(chain.states()) {
    for (std::uint32_t state = 0; state < chain.states(); ++state) {
      policy_.push_back(static_cast<std::uint8_t>(chain.policy(state)));
    }
  }

  int of(const Tree& tree) {
    fill_action_table(tree, columns_, static_cast<std::uint8_t>(kNoAction), actions_);
    int matches = 0;
    for (std::size_t state = 0; state < policy_.size(); ++state) {
      matches += actions_[state] == policy_[state] ? 1 : 0;
    }
    return matches;
  }

 private:
  StateColumns columns_;
  std::vector<std::uint8_t> policy_;
  std::vector<std::uint8_t> actions_;
};

struct Found {
  Tree tree;
  int states = 0;
};

Found anneal(const Chain& chain, std::size_t nodes, std::uint64_t seed, std::uint64_t steps) {
  const Breeding breeding(chain.vocabulary(), {.max_depth = 8, .max_children = 8, .max_nodes = nodes});
  Coverage coverage(chain);
  Stream stream(seed, Purpose::breeding, 0, 0);
  Tree tree = breeding.grow(stream);
  int states = coverage.of(tree);
  Found best{tree, states};
  for (std::uint64_t step = 0; step < steps; ++step) {
    const double done = static_cast<double>(step) / static_cast<double>(steps);
    const double temperature = kHot * std::pow(kCold / kHot, done);
    Tree next = stream.below(kBold) == 0 ? breeding.mutate_subtree(stream, tree) : breeding.edit(stream, tree);
    const int reached = coverage.of(next);
    if (stream.chance(std::exp(std::min(reached - states, 0) / temperature))) {
      tree = std::move(next);
      states = reached;
    }
    if (states > best.states) {
      best = {tree, states};
    }
  }
  return best;
}

int fail(const std::string& what) {
  fmt::print(stderr, "annealing: {}\n", what);
  return 2;
}

int run(int argc, char** argv) {
  std::uint64_t numbers[3];
  if (argc != 5) {
    return fail("usage: annealing STUDY NODES SEED STEPS");
  }
  for (int i = 0; i < 3; ++i) {
    const std::string_view text = argv[i + 2];
    if (std::from_chars(text.begin(), text.end(), numbers[i]).ptr != text.end() || numbers[i] == 0) {
      return fail(fmt::format("'{}': expected a number of 1 or more", text));
    }
  }
  const auto study = Study::open(argv[1], Study::Access::read);
  if (!study) {
    return fail(study.error().message);
  }
  const Chain& chain = study->chain();
  const Found found = anneal(chain, numbers[0], numbers[1], numbers[2]);
  fmt::print("{} of {} states ({:.1f} %), {} nodes: {}\n", found.states, chain.states(),
             100.0 * found.states / static_cast<double>(chain.states()), found.tree.size(),
             to_text(found.tree, chain.vocabulary()));
  return 0;
}

}  // namespace
}  // namespace coppice

int main(int argc, char** argv) { return coppice::run(argc, argv); }
