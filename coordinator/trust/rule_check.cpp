#include "coordinator/trust/rule_check.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <string>
#include <utility>

#include "coordinator/trust/jumps.hpp"

namespace coppice {
namespace {

constexpr unsigned kByte = 8;

// For each feature that the tree tests, its values in classes that no test of the tree, nor the rule, tells apart. A
// box is a string of bits, one a class: what is still possible.
class Classes {
 public:
  Classes(const Tree& tree, const Vocabulary& vocabulary, const std::vector<ValueSet>& allowed)
      : features_(vocabulary.features.size()), masks_(tree.size()), last_test_(vocabulary.features.size(), 0) {
    for (std::size_t node = 0; node < tree.size(); ++node) {
      if (tree[node].kind == NodeKind::condition) {
        features_[tree[node].index].tested = true;
        last_test_[tree[node].index] = node;
      }
    }
    for (std::size_t f = 0; f < features_.size(); ++f) {
      if (features_[f].tested) {
        classify(f, tree, vocabulary.features[f], allowed[f]);
      }
    }
    for (std::size_t node = 0; node < tree.size(); ++node) {
      if (tree[node].kind == NodeKind::condition) {
        masks_[node] = mask_of(tree[node]);
      }
    }
  }

  // Everything that the rule allows.
  const std::string& all() const { return all_; }

  // The box where the condition at `node` holds, or fails; empty if nowhere.
  std::string split(const std::string& box, const Node& condition, std::size_t node, bool wanted) const {
    const Place& place = features_[condition.index];
    std::string part = box;
    bool any = false;
    for (std::size_t i = 0; i < place.bytes; ++i) {
      const auto mask = static_cast<unsigned char>(masks_[node][i]);
      const auto byte = static_cast<unsigned char>(box[place.at + i]);
      const auto kept = static_cast<unsigned char>(wanted ? byte & mask : byte & static_cast<unsigned char>(~mask));
      part[place.at + i] = static_cast<char>(kept);
      any = any || kept != 0;
    }
    return any ? part : std::string();
  }

  // The box without what no leaf from `leaf` on asks for.
  std::string seen_from(const std::string& box, std::size_t leaf) const {
    std::string key = box;
    for (std::size_t f = 0; f < features_.size(); ++f) {
      if (features_[f].tested && (leaf == kTickEnds || last_test_[f] < leaf)) {
        std::fill_n(key.begin() + static_cast<std::ptrdiff_t>(features_[f].at), features_[f].bytes, '\0');
      }
    }
    return key;
  }

  bool tested(std::size_t feature) const { return features_[feature].tested; }
  // Whether the box says more of a feature than the rule does.
  bool narrowed(const std::string& box, std::size_t feature) const {
    const Place& place = features_[feature];
    return place.tested && box.compare(place.at, place.bytes, all_, place.at, place.bytes) != 0;
  }
  // The lowest value that is possible. REQUIRES: tested.
  std::uint8_t lowest(const std::string& box, std::size_t feature) const {
    const Place& place = features_[feature];
    std::uint8_t value = 255;
    for (std::size_t c = 0; c < place.values.size(); ++c) {
      if (bit(box, place.at, c)) {
        value = std::min(value, place.values[c].front());
      }
    }
    return value;
  }

 private:
  struct Place {
    bool tested = false;
    std::size_t at = 0;  // first byte
    std::size_t bytes = 0;
    std::vector<std::vector<std::uint8_t>> values;  // by class, ascending
  };

  static bool bit(const std::string& box, std::size_t at, std::size_t c) {
    return ((static_cast<unsigned char>(box[at + c / kByte]) >> (c % kByte)) & 1U) != 0;
  }
  static void set_bit(std::string& box, std::size_t at, std::size_t c) {
    box[at + c / kByte] = static_cast<char>(static_cast<unsigned char>(box[at + c / kByte]) | (1U << (c % kByte)));
  }

  void classify(std::size_t f, const Tree& tree, const Feature& feature, const ValueSet& allowed) {
    std::map<std::vector<bool>, std::vector<std::uint8_t>> by_signature;
    for (const std::uint8_t value : feature.values) {
      std::vector<bool> signature{allowed.test(value)};
      for (const Node& node : tree.nodes()) {
        if (node.kind == NodeKind::condition && node.index == f) {
          signature.push_back(coppice::holds(node, value));
        }
      }
      by_signature[signature].push_back(value);
    }
    Place& place = features_[f];
    place.at = all_.size();
    place.bytes = (by_signature.size() + kByte - 1) / kByte;
    all_.resize(all_.size() + place.bytes, '\0');
    for (const auto& [signature, values] : by_signature) {
      if (signature.front()) {
        set_bit(all_, place.at, place.values.size());
      }
      place.values.push_back(values);
    }
  }

  std::string mask_of(const Node& condition) const {
    const Place& place = features_[condition.index];
    std::string mask(place.bytes, '\0');
    for (std::size_t c = 0; c < place.values.size(); ++c) {
      if (coppice::holds(condition, place.values[c].front())) {
        set_bit(mask, 0, c);
      }
    }
    return mask;
  }

  std::vector<Place> features_;
  std::vector<std::string> masks_;      // [nodes] classes in which a condition holds
  std::vector<std::size_t> last_test_;  // [features] the last node that tests it
  std::string all_;
};

class Proof {
 public:
  Proof(const Rule& rule, const Tree& tree, const Vocabulary& vocabulary)
      : rule_(rule), tree_(tree), vocabulary_(vocabulary), jumps_(jumps_of(tree)) {
    answer_.nodes.resize(tree.size());
  }

  Result<RuleAnswer> run() {
    for (const std::vector<ValueSet>& allowed : rule_.when) {
      if (const Result<void> done = walk(allowed); !done) {
        return tl::unexpected(done.error());
      }
    }
    // A composite was ticked when something in it was. From the last to the first: children before their parent.
    for (std::size_t node = tree_.size(); node-- > 0;) {
      if (tree_[node].is_composite()) {
        const auto begin = answer_.nodes.begin() + static_cast<std::ptrdiff_t>(node);
        answer_.nodes[node].ticked =
            std::any_of(begin + 1, begin + tree_[node].extent, [](const NodeRole& role) { return role.ticked; });
      }
    }
    return std::move(answer_);
  }

 private:
  // By what it will do from here on; with one box of all that came to it, for a counterexample.
  using States = std::map<std::string, std::string>;

  static std::string key_of(const std::string& box, std::size_t writer) {
    std::string key = box;
    key += static_cast<char>(writer & 0xFFU);
    key += static_cast<char>(writer >> kByte);
    return key;
  }
  static std::size_t writer_in(const std::string& key) {
    return static_cast<unsigned char>(key[key.size() - 2]) |
           static_cast<std::size_t>(static_cast<unsigned char>(key.back())) << kByte;
  }

  Result<void> walk(const std::vector<ValueSet>& allowed) {
    const Classes classes(tree_, vocabulary_, allowed);
    std::map<std::size_t, States> waiting;  // by leaf; jumps go forward, so the first is never joined again
    const auto arrive = [&](std::size_t leaf, const std::string& box, std::size_t writer) {
      if (leaf == kTickEnds) {
        end(classes, allowed, box, writer);
        return;
      }
      waiting[leaf].try_emplace(key_of(classes.seen_from(box, leaf), writer), box);
    };
    arrive(first_leaf(tree_, 0), classes.all(), kTickEnds);
    while (!waiting.empty()) {
      const auto [leaf, states] = std::move(*waiting.begin());
      waiting.erase(waiting.begin());
      answer_.states += states.size();
      if (answer_.states > kMaxRuleStates) {
        return failed(fmt::format("the proof of '{}' takes more than {} states: expected a smaller tree", rule_.text,
                                  kMaxRuleStates));
      }
      NodeRole& role = answer_.nodes[leaf];
      role.ticked = true;
      for (const auto& [key, box] : states) {
        if (tree_[leaf].kind == NodeKind::action) {
          role.succeeds = true;
          arrive(jumps_[leaf].on_success, box, leaf);
          continue;
        }
        if (const std::string part = classes.split(box, tree_[leaf], leaf, true); !part.empty()) {
          role.succeeds = true;
          arrive(jumps_[leaf].on_success, part, writer_in(key));
        }
        if (const std::string part = classes.split(box, tree_[leaf], leaf, false); !part.empty()) {
          role.fails = true;
          arrive(jumps_[leaf].on_failure, part, writer_in(key));
        }
      }
    }
    return {};
  }

  void end(const Classes& classes, const std::vector<ValueSet>& allowed, const std::string& box, std::size_t writer) {
    ActionId action = kNoAction;
    if (writer != kTickEnds) {
      answer_.nodes[writer].last_word = true;
      action = tree_[writer].action();
    }
    if (!rule_.broken_by(action)) {
      return;
    }
    Counterexample example{.features = {}, .matters = {}, .action = action, .writer = writer};
    for (std::size_t f = 0; f < allowed.size(); ++f) {
      const std::vector<std::uint8_t>& values = vocabulary_.features[f].values;
      const auto first = std::find_if(values.begin(), values.end(), [&](std::uint8_t v) { return allowed[f].test(v); });
      example.features.push_back(classes.tested(f) ? classes.lowest(box, f) : *first);
      example.matters.push_back(classes.narrowed(box, f) || allowed[f].count() < values.size());
    }
    if (!answer_.broken || example.features < answer_.broken->features) {
      answer_.broken = std::move(example);
    }
  }

  const Rule& rule_;
  const Tree& tree_;
  const Vocabulary& vocabulary_;
  std::vector<Jump> jumps_;
  RuleAnswer answer_;
};

}  // namespace

std::size_t RuleAnswer::ticked() const {
  return static_cast<std::size_t>(
      std::count_if(nodes.begin(), nodes.end(), [](const NodeRole& role) { return role.ticked; }));
}

Result<RuleAnswer> check_rule(const Rule& rule, const Tree& tree, const Vocabulary& vocabulary) {
  return Proof(rule, tree, vocabulary).run();
}

}  // namespace coppice
