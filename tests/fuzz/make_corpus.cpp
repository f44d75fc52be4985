// Writes the binary part of the corpus: tasks, answers and chains, well formed and damaged in ways that a random change
// would take long to find. The files are kept in corpus/: `make_corpus tests/fuzz/corpus` after a format has changed;
// with --check it writes nothing and fails if a kept file is not what it would write.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/chain/bytes.hpp"
#include "common/chain/chain_bytes.hpp"
#include "common/check.hpp"
#include "common/tree/text.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/epoch_codec.hpp"
#include "tests/fuzz/epochs.hpp"
#include "tests/fuzz/words.hpp"
#include "tests/oracles/chains.hpp"
#include "tests/oracles/trees.hpp"

namespace coppice::fuzz {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

// One folder of the corpus. Every file in it is made here.
class Folder {
 public:
  Folder(fs::path path, bool check) : path_(std::move(path)), check_(check) { fs::create_directories(path_); }

  void write(const std::string& name, const Bytes& bytes) {
    const std::string path = (path_ / name).string();
    names_.insert(name);
    if (check_) {
      std::ifstream file(path, std::ios::binary);
      if (!file || Bytes(std::istreambuf_iterator<char>(file), {}) != bytes) {
        throw std::runtime_error(path + ": is not what make_corpus makes: run it again");
      }
      return;
    }
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) {
      throw std::runtime_error(path + ": cannot be written");
    }
  }

  void finish() const {
    for (const auto& entry : fs::directory_iterator(path_)) {
      if (names_.count(entry.path().filename().string()) == 0) {
        throw std::runtime_error(entry.path().string() + ": make_corpus does not make it: remove it");
      }
    }
  }

 private:
  fs::path path_;
  bool check_;
  std::set<std::string> names_;
};

Tree tree(std::string_view text) {
  auto parsed = parse_tree(text, words());
  COPPICE_CHECK(parsed.has_value());
  return *parsed;
}

Tree deepest_tree() {
  std::vector<Node> nodes;
  for (std::size_t depth = 0; depth < kMaxTreeDepth; ++depth) {
    nodes.push_back(
        Node::composite(depth % 2 == 0 ? NodeKind::sequence : NodeKind::selector, kMaxTreeDepth + 1 - depth));
  }
  nodes.push_back(Node::action(ActionId{0}));
  auto made = Tree::from_nodes(std::move(nodes));
  COPPICE_CHECK(made.has_value());
  return *made;
}

Job small_job() {
  Job job;
  job.seed = 0x0123456789ABCDEF;
  job.generation = 3;
  job.rollouts = 2;
  job.steps = 10;
  return job;
}

Job every_objective() {
  Job job = small_job();
  job.rollouts = 9;
  job.acting = Acting::mixed;
  job.policy_share = std::uint64_t{1} << 63U;
  job.objectives.clear();
  for (std::uint8_t kind = 0; kind < kObjectiveKinds; ++kind) {
    job.objectives.push_back({ObjectiveKind{kind}, {}});
  }
  job.objectives[static_cast<std::size_t>(ObjectiveKind::seen)].threshold = 100.0;
  job.objectives[static_cast<std::size_t>(ObjectiveKind::collisions)].threshold = -10.0;
  job.start = Start::visits;
  job.objectives[static_cast<std::size_t>(ObjectiveKind::shaped)].rules = {
      {{Node::condition(3, Op::equal, 3), Node::condition(8, Op::less_equal, 4)}, 8, -4},
      {{Node::condition(9, Op::less_equal, 100)},
       std::numeric_limits<std::int32_t>::max(),
       std::numeric_limits<std::int32_t>::min()},
      {{}, 1, 0}};
  return job;
}

Job most_rules() {
  Job job = small_job();
  ShapedRule rule;
  rule.any_of.assign(kMaxShapedConditions, Node::condition(0, Op::equal, 1));
  job.objectives = {{ObjectiveKind::shaped, std::vector<ShapedRule>(kMaxShapedRules, rule)}};
  return job;
}

// Offsets in a task of one objective without rules and one tree; see common/wire/codec.hpp.
constexpr std::size_t kRolloutsAt = 12;
constexpr std::size_t kActingAt = 20;
constexpr std::size_t kMethodAt = 29;
constexpr std::size_t kGammaAt = 30;
constexpr std::size_t kStartAt = 38;
constexpr std::size_t kObjectivesAt = 39;
constexpr std::size_t kKindAt = 40;
constexpr std::size_t kThresholdAt = 41;
constexpr std::size_t kRulesAt = 49;
constexpr std::size_t kTreesAt = 50;
constexpr std::size_t kNodesAt = 54;
constexpr std::size_t kFirstNodeAt = 56;

void write_tasks(Folder& folder) {
  const std::vector<Tree> trees = {
      tree("move"), tree("(selector (sequence s3=0 turn_left) (sequence x<=4 y<=10) move)"), tree("s0=1")};
  const Bytes task = wire::encode_task(small_job(), trees);
  folder.write("three_trees", task);
  folder.write("no_trees", wire::encode_task(small_job(), {}));
  folder.write("every_objective", wire::encode_task(every_objective(), trees));
  folder.write("most_rules", wire::encode_task(most_rules(), std::vector<Tree>{tree("turn_right")}));
  folder.write("deepest_tree", wire::encode_task(small_job(), std::vector<Tree>{deepest_tree()}));
  folder.write("many_trees", wire::encode_task(small_job(), oracles::random_trees(words(), 100, 1)));
  Job longest = small_job();
  longest.rollouts = 16;
  longest.steps = kMaxSteps;
  longest.acting = Acting::policy;
  folder.write("longest_walks", wire::encode_task(longest, trees));
  for (std::uint8_t method = 1; method < kMethods; ++method) {
    Job computed = every_objective();
    computed.method = Method{method};
    computed.start = Start::initial;
    computed.gamma = computed.method == Method::discounted ? fixed_point_share(0.95) : 0;
    folder.write(std::string(name_of(computed.method)), wire::encode_task(computed, trees));
  }

  const Bytes good = wire::encode_task(small_job(), std::vector<Tree>{tree("(sequence s3=0 move)")});
  const auto damaged = [&](const std::string& name, std::size_t at, std::uint8_t value) {
    Bytes bytes = good;
    bytes.at(at) = value;
    folder.write("bad_" + name, bytes);
  };
  folder.write("sequence", good);
  damaged("no_rollouts", kRolloutsAt, 0);
  damaged("acting", kActingAt, 3);
  damaged("method", kMethodAt, kMethods);
  damaged("start", kStartAt, kStarts);
  damaged("threshold_of_agreement", kThresholdAt, 1);
  damaged("gamma_without_discount", kGammaAt, 1);
  damaged("no_objectives", kObjectivesAt, 0);
  damaged("too_many_objectives", kObjectivesAt, 17);
  damaged("objective", kKindAt, kObjectiveKinds);
  damaged("too_many_rules", kRulesAt, 255);
  damaged("too_few_trees", kTreesAt, 0);
  damaged("too_many_trees", kTreesAt + 3, 255);
  damaged("too_many_nodes", kNodesAt + 1, 255);
  damaged("node_tag", kFirstNodeAt, 8);
  damaged("operator_of_a_sequence", kFirstNodeAt, 4);
  damaged("extent_0", kFirstNodeAt + 1, 0);
  damaged("extent_1", kFirstNodeAt + 1, 1);
  damaged("extent_beyond_the_tree", kFirstNodeAt + 1, 4);
  damaged("feature", kFirstNodeAt + 4, 10);
  damaged("value", kFirstNodeAt + 5, 2);
  damaged("action", kFirstNodeAt + 7, 3);
  folder.write("bad_empty", {});
  folder.write("bad_cut_short", {good.begin(), good.end() - 1});
  Bytes surplus = good;
  surplus.push_back(0);
  folder.write("bad_surplus", surplus);
}

// As the target reads it: how many trees and objectives were asked about, then the payload.
Bytes asked(std::uint8_t trees, std::uint8_t objectives, const Bytes& payload) {
  ByteWriter writer;
  writer.put(trees);
  writer.put(objectives);
  writer.put_all(payload);
  return writer.take();
}

void write_answers(Folder& folder) {
  constexpr std::int64_t kLowest = std::numeric_limits<std::int64_t>::min();
  const std::vector<Tally> two = {{5, 17, 500, {17, -3}}, {4096, ~std::uint64_t{0}, ~std::uint64_t{0}, {kLowest, -1}}};
  const Bytes payload = wire::encode_tallies(two);
  folder.write("two", asked(2, 2, payload));
  folder.write("none", asked(0, 1, wire::encode_tallies({})));
  folder.write("no_objectives", asked(1, 0, wire::encode_tallies(std::vector<Tally>{{1, 2, 3, {}}})));
  folder.write(
      "many",
      asked(100, 16,
            wire::encode_tallies(std::vector<Tally>(100, {7, 1, 2, std::vector<std::int64_t>(kMaxObjectives, 9)}))));
  folder.write("bad_empty", {});
  folder.write("bad_no_payload", asked(2, 2, {}));
  folder.write("bad_too_few", asked(3, 2, payload));
  folder.write("bad_too_many", asked(1, 2, payload));
  folder.write("bad_objectives", asked(2, 3, payload));
  folder.write("bad_cut_short", asked(2, 2, {payload.begin(), payload.end() - 1}));
  // 2^32 - 1 tallies, to be counted before memory is taken
  folder.write("bad_count", asked(2, 2, {255, 255, 255, 255, 0, 0}));
}

constexpr std::array<const char*, kSampleEpochs> kEpochNames = {"scalar_begins", "scalar_goes_on", "front_begins",
                                                                "front_goes_on"};

Bytes packed(const EvolveConfig& config, const EpochTask& task) {
  return wire::encode_epoch_task(wire::encode_configuration(config, task.deme == nullptr), task);
}

void write_epoch_tasks(Folder& folder) {
  const Chain chain = small_chain();
  for (std::size_t which = 0; which < kSampleEpochs; ++which) {
    const auto [config, task, result] = sample_epoch(which, chain);
    const Bytes good = packed(*config, task);
    const std::string name = kEpochNames[which];
    folder.write(name, good);
    folder.write("bad_" + name + "_cut_short", {good.begin(), good.end() - 1});
    Bytes surplus = good;
    surplus.push_back(0);
    folder.write("bad_" + name + "_surplus", surplus);
    // As if it were the other kind: founders where nothing begins, none where something does.
    folder.write("bad_" + name + "_founders",
                 wire::encode_epoch_task(wire::encode_configuration(*config, task.deme != nullptr), task));
    const auto changed = [&](const char* what, const std::function<void(EpochTask&)>& change) {
      EpochTask other = task;
      change(other);
      folder.write("bad_" + name + "_" + what, packed(*config, other));
    };
    changed("deme", [&](EpochTask& other) { other.number = config->ga.demes; });
    changed("until", [&](EpochTask& other) { other.until = config->ga.generations + 1; });
    changed("nothing_to_do", [&](EpochTask& other) { other.until = other.deme ? other.deme->generations : 0; });
    if (task.deme) {
      changed("too_many_migrants", [](EpochTask& other) { other.migrants.push_back(other.migrants.front()); });
      changed("too_few_individuals", [](EpochTask& other) {
        Deme fewer = *other.deme;
        fewer.population.pop_back();
        other.deme = std::make_shared<const Deme>(std::move(fewer));
      });
      changed("matches", [](EpochTask& other) { other.migrants.front().tally.matches = 21; });
    }
  }
  EvolveConfig wide = *sample_epoch(2, chain).config;
  wide.ga.guided = 0.5;
  wide.ga.guided_steps = 2;
  wide.ga.form = Form::guarded;
  wide.ga.seeding = Seeding::greedy;
  wide.ga.max_nodes = 15;
  wide.ga.edits = 0.5;
  wide.ga.local_search = 0.25;
  wide.ga.simplify = Simplification::lossless;
  wide.front.restarts = 1;
  wide.rollout.method = Method::discounted;
  wide.ga.founders.clear();
  folder.write("guided_and_guarded", packed(wide, sample_epoch(2, chain).task));
  folder.write("bad_empty", {});
  folder.write("bad_size_of_the_configuration", {255, 255, 255, 255, 0});
}

void write_epoch_results(Folder& folder) {
  const Chain chain = small_chain();
  for (std::size_t which = 0; which < kSampleEpochs; ++which) {
    const auto [config, task, result] = sample_epoch(which, chain);
    const std::string name = kEpochNames[which];
    const auto answer = [&](const EpochResult& given) {
      Bytes bytes = wire::encode_epoch_result(given);
      bytes.insert(bytes.begin(), static_cast<std::uint8_t>(which));
      return bytes;
    };
    const Bytes good = answer(result);
    folder.write(name, good);
    folder.write("bad_" + name + "_cut_short", {good.begin(), good.end() - 1});
    const auto changed = [&](const char* what, const std::function<void(EpochResult&)>& change) {
      EpochResult other = result;
      change(other);
      folder.write("bad_" + name + "_" + what, answer(other));
    };
    changed("generations", [](EpochResult& other) { ++other.deme.generations; });
    changed("too_few_records", [](EpochResult& other) { other.records.pop_back(); });
    changed("too_many_emigrants", [](EpochResult& other) { other.emigrants.push_back(other.emigrants.front()); });
    changed("too_many_individuals",
            [](EpochResult& other) { other.deme.population.push_back(other.deme.population.front()); });
    changed("not_a_number",
            [](EpochResult& other) { other.records[0].mean_fitness = std::numeric_limits<double>::quiet_NaN(); });
    // Scores of one objective more than were asked for.
    changed("scores", [](EpochResult& other) { other.deme.population.back().tally.scores.push_back(1); });
  }
  folder.write("bad_empty", {});
  folder.write("bad_no_payload", {1});
}

Bytes changed(const Chain& chain, const std::function<void(ChainParts&)>& change) {
  ChainParts parts = chain.parts();
  change(parts);
  auto made = Chain::make(std::move(parts));
  if (!made) {
    throw std::runtime_error(made.error().message);
  }
  return to_bytes(*made);
}

void write_chains(Folder& folder) {
  const Chain chain = small_chain();
  const Bytes good = to_bytes(chain);
  folder.write("small", good);
  folder.write("die", to_bytes(oracles::knuth_die()));
  folder.write("ruin", to_bytes(oracles::gamblers_ruin({})));
  folder.write("random", to_bytes(oracles::random_chain({.states = 40, .actions = 8, .seed = 2})));
  folder.write("largest_counts", changed(chain, [](ChainParts& parts) {
                 for (std::size_t row = 0; row + 1 < parts.row_begin.size(); ++row) {
                   if (parts.row_begin[row] != parts.row_begin[row + 1]) {
                     parts.count[parts.row_begin[row]] = 0xFFFFF000;
                   }
                 }
               }));
  folder.write("values_too_large_to_score", changed(chain, [](ChainParts& parts) {
                 parts.q.front() = std::numeric_limits<double>::max();
                 parts.reward_sum.back() = -std::numeric_limits<double>::max();
               }));
  folder.write("minus_zero_and_subnormal", changed(chain, [](ChainParts& parts) {
                 parts.q.front() = -0.0;
                 parts.reward_sum.back() = std::numeric_limits<double>::denorm_min();
               }));
  folder.write("most_visits", changed(chain, [](ChainParts& parts) {
                 parts.visits.assign(parts.visits.size(), 0);
                 parts.visits.back() = (std::uint64_t{1} << 62U) - 1;
               }));
  Bytes visits = good;  // they are its last part; their sum is a signed score
  std::fill(visits.end() - static_cast<std::ptrdiff_t>(8 * chain.states()), visits.end(), std::uint8_t{0x7F});
  folder.write("bad_visits_beyond_a_score", visits);

  constexpr std::size_t kFeaturesAt = 8;
  const std::size_t after_vocabulary = good.size() - [&] {
    const ChainParts& parts = chain.parts();
    return 20 + parts.features.size() + parts.row_begin.size() * 8 + parts.successor.size() * 8 + parts.q.size() * 16 +
           parts.policy.size() * 9;
  }();
  const auto damaged = [&](const std::string& name, std::size_t at, std::uint8_t value) {
    Bytes bytes = good;
    bytes.at(at) = value;
    folder.write("bad_" + name, bytes);
  };
  damaged("magic", 0, 'X');
  damaged("format", 4, 2);
  damaged("no_features", kFeaturesAt, 0);
  damaged("too_many_features", kFeaturesAt + 1, 255);
  damaged("name_length", kFeaturesAt + 3, 255);
  damaged("name", kFeaturesAt + 4, '\n');
  damaged("states", after_vocabulary, 13);
  damaged("most_states", after_vocabulary + 7, 255);
  damaged("most_transitions", after_vocabulary + 15, 255);
  damaged("initial_state", after_vocabulary + 16, 12);
  damaged("feature_value", after_vocabulary + 20, 2);
  damaged("policy", good.size() - 12 * 9, 3);
  const Bytes full = to_bytes(full_chain());
  folder.write("full", full);
  folder.write("bad_full_cut_short", {full.begin(), full.end() - 1});
  Bytes other_format = full;
  other_format.at(4) = 1;
  folder.write("bad_full_called_plain", other_format);
  Bytes collided = full;  // the last number of collisions
  std::fill(collided.end() - 4, collided.end(), std::uint8_t{0xFF});
  folder.write("bad_more_collisions_than_tries", collided);
  folder.write("bad_empty", {});
  folder.write("bad_cut_short", {good.begin(), good.end() - 1});
  folder.write("bad_header_only", {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(after_vocabulary + 20)});
  Bytes surplus = good;
  surplus.push_back(0);
  folder.write("bad_surplus", surplus);
}

void write_corpus(const fs::path& corpus, bool check) {
  struct Part {
    const char* name;
    void (*write)(Folder&);
  };
  for (const Part& part :
       {Part{"task", write_tasks}, Part{"answer", write_answers}, Part{"epoch_task", write_epoch_tasks},
        Part{"epoch_result", write_epoch_results}, Part{"chain_bytes", write_chains}}) {
    Folder folder(corpus / part.name, check);
    part.write(folder);
    folder.finish();
  }
}

}  // namespace
}  // namespace coppice::fuzz

int main(int argc, char** argv) {
  const bool check = argc == 3 && std::string_view(argv[2]) == "--check";
  if ((argc != 2 && !check) || argv[1][0] == '-') {
    fmt::print(stderr, "expected: make_corpus FOLDER [--check], such as make_corpus tests/fuzz/corpus\n");
    return 2;
  }
  try {
    coppice::fuzz::write_corpus(argv[1], check);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
