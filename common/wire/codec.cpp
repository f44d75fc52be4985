#include "common/wire/codec.hpp"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <utility>

#include "common/check.hpp"
#include "common/wire/node_layout.hpp"

namespace coppice::wire {
namespace {

void put_job(const Job& job, ByteWriter& writer) {
  writer.put(job.seed);
  writer.put(job.generation);
  writer.put(job.rollouts);
  writer.put(job.steps);
  writer.put(job.acting);
  writer.put(job.policy_share);
  writer.put(job.method);
  writer.put(job.gamma);
  writer.put(job.start);
  writer.put(static_cast<std::uint8_t>(job.objectives.size()));
  for (const Objective& objective : job.objectives) {
    writer.put(objective.kind);
    writer.put(objective.threshold);
    writer.put(static_cast<std::uint8_t>(objective.rules.size()));
    for (const ShapedRule& rule : objective.rules) {
      writer.put(rule.right);
      writer.put(rule.wrong);
      writer.put(static_cast<std::uint8_t>(rule.any_of.size()));
      for (const Node& condition : rule.any_of) {
        put_node(condition, writer);
      }
    }
  }
}

Result<std::vector<ShapedRule>> get_rules(ByteReader& reader) {
  const auto count = reader.get<std::uint8_t>();
  if (count > kMaxShapedRules) {
    return bad_input(fmt::format("objective has {} rules: expected at most {}", count, kMaxShapedRules));
  }
  std::vector<ShapedRule> rules;
  for (std::uint8_t i = 0; i < count; ++i) {
    ShapedRule rule;
    rule.right = reader.get<std::int32_t>();
    rule.wrong = reader.get<std::int32_t>();
    const auto conditions = reader.get<std::uint8_t>();
    if (conditions > kMaxShapedConditions) {
      return bad_input(fmt::format("rule has {} conditions: expected at most {}", conditions, kMaxShapedConditions));
    }
    for (std::uint8_t j = 0; j < conditions; ++j) {
      Node node;
      if (!get_node(reader, node)) {
        return unknown_node(node.value);
      }
      rule.any_of.push_back(node);
    }
    rules.push_back(std::move(rule));
  }
  return rules;
}

Result<Job> get_job(ByteReader& reader) {
  Job job;
  job.seed = reader.get<std::uint64_t>();
  job.generation = reader.get<std::uint32_t>();
  job.rollouts = reader.get<std::uint32_t>();
  job.steps = reader.get<std::uint32_t>();
  const auto acting = reader.get<std::uint8_t>();
  job.policy_share = reader.get<std::uint64_t>();
  const auto method = reader.get<std::uint8_t>();
  job.gamma = reader.get<std::uint64_t>();
  const auto start = reader.get<std::uint8_t>();
  const auto objectives = reader.get<std::uint8_t>();
  if (acting > static_cast<std::uint8_t>(Acting::mixed)) {
    return bad_input(fmt::format("acting policy {} is unknown", acting));
  }
  job.acting = static_cast<Acting>(acting);
  if (method >= kMethods) {
    return bad_input(fmt::format("method {} is unknown", method));
  }
  job.method = static_cast<Method>(method);
  if (start >= kStarts) {
    return bad_input(fmt::format("start {} is unknown", start));
  }
  job.start = static_cast<Start>(start);
  if (objectives > kMaxObjectives) {
    return bad_input(fmt::format("job has {} objectives: expected at most {}", objectives, kMaxObjectives));
  }
  job.objectives.clear();
  for (std::uint8_t i = 0; i < objectives; ++i) {
    const auto kind = reader.get<std::uint8_t>();
    if (kind >= kObjectiveKinds) {
      return bad_input(fmt::format("objective {} is unknown", kind));
    }
    const auto threshold = reader.get<double>();
    auto rules = get_rules(reader);
    if (!rules) {
      return tl::unexpected(rules.error());
    }
    job.objectives.push_back({static_cast<ObjectiveKind>(kind), std::move(*rules), threshold});
  }
  if (!reader.ok()) {
    return bad_input("job is cut short");
  }
  if (auto ok = check_job(job); !ok) {
    return tl::unexpected(ok.error());
  }
  return job;
}

template <typename TreeAt>
std::vector<std::uint8_t> encode(const Job& job, std::size_t trees, const TreeAt& tree_at) {
  COPPICE_CHECK(trees <= kMaxTreesPerTask);
  ByteWriter writer;
  put_job(job, writer);
  writer.put(static_cast<std::uint32_t>(trees));
  std::vector<std::uint8_t> bytes = writer.take();
  const std::size_t head = bytes.size();
  std::size_t most = head + kWord;
  for (std::size_t i = 0; i < trees; ++i) {
    most += most_encoded_bytes(tree_at(i).size());
  }
  bytes.resize(most);
  std::uint8_t* at = bytes.data() + head;
  for (std::size_t i = 0; i < trees; ++i) {
    at = write_tree(tree_at(i), at);
  }
  const auto size = static_cast<std::size_t>(at - bytes.data());
  COPPICE_CHECK(size <= most);
  bytes.resize(size);
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> encode_task(const Job& job, std::span<const Tree> trees) {
  return encode(job, trees.size(), [&](std::size_t i) -> const Tree& { return trees[i]; });
}

std::vector<std::uint8_t> encode_task(const Job& job, std::span<const Tree> trees,
                                      std::span<const std::uint32_t> places) {
  return encode(job, places.size(), [&](std::size_t i) -> const Tree& { return trees[places[i]]; });
}

Result<DecodedTask> TaskDecoder::decode(std::span<const std::uint8_t> payload) {
  ByteReader reader(payload);
  auto job = get_job(reader);
  if (!job) {
    return tl::unexpected(job.error());
  }
  const auto count = reader.get<std::uint32_t>();
  if (count > kMaxTreesPerTask) {
    return bad_input(fmt::format("task has {} trees: expected at most {}", count, kMaxTreesPerTask));
  }
  DecodedTask task{std::move(*job), std::exchange(trees_, {})};
  task.trees.reserve(std::min<std::size_t>(count, reader.left()));
  if (!reader.ok()) {
    return bad_input("task is cut short");
  }
  std::span<const std::uint8_t> rest = payload.last(reader.left());
  for (std::uint32_t i = 0; i < count; ++i) {
    auto tree = read_tree(rest);
    if (!tree) {
      return in_context(fmt::format("tree {}", i), tree.error());
    }
    task.trees.push_back(std::move(*tree));
  }
  if (!rest.empty()) {
    return bad_input(fmt::format("{} bytes follow the task", rest.size()));
  }
  return task;
}

void TaskDecoder::recycle(DecodedTask&& task) {
  for (Tree& tree : task.trees) {
    nodes_.push_back(std::move(tree).take_nodes());
  }
  task.trees.clear();
  trees_ = std::move(task.trees);
}

// Reads one tree from the front of `bytes`, and takes it off.
Result<Tree> TaskDecoder::read_tree(std::span<const std::uint8_t>& bytes) {
  std::vector<Node> nodes;
  if (!nodes_.empty()) {
    nodes = std::move(nodes_.back());
    nodes_.pop_back();
  }
  if (auto ok = read_nodes(bytes, nodes); !ok) {
    return tl::unexpected(ok.error());
  }
  auto tree = Tree::from_nodes(std::move(nodes));
  if (!tree) {
    return tree;
  }
  if (auto ok = checker_.check(*tree); !ok) {
    return tl::unexpected(ok.error());
  }
  return tree;
}

std::size_t encoded_tally_size(std::size_t objectives) {
  return sizeof(std::uint32_t) + (2 + objectives) * sizeof(std::uint64_t);
}

std::vector<std::uint8_t> encode_tallies(std::span<const Tally> tallies) {
  ByteWriter writer;
  writer.reserve(sizeof(std::uint32_t) +
                 (tallies.empty() ? 0 : tallies.size() * encoded_tally_size(tallies.front().scores.size())));
  writer.put(static_cast<std::uint32_t>(tallies.size()));
  for (const Tally& tally : tallies) {
    writer.put(tally.nodes);
    writer.put(tally.matches);
    writer.put(tally.steps);
    writer.put_all(tally.scores);
  }
  return writer.take();
}

Result<std::vector<Tally>> decode_tallies(std::span<const std::uint8_t> payload, std::size_t trees,
                                          std::size_t objectives) {
  ByteReader reader(payload);
  const auto count = reader.get<std::uint32_t>();
  const std::size_t each = encoded_tally_size(objectives);
  if (!reader.ok() || count != trees || reader.left() != trees * each) {
    return bad_input(fmt::format("answer of {} bytes says {} tallies: expected {} of {} bytes each", payload.size(),
                                 count, trees, each));
  }
  std::vector<Tally> tallies(trees);
  for (Tally& tally : tallies) {
    tally.nodes = reader.get<std::uint32_t>();
    tally.matches = reader.get<std::uint64_t>();
    tally.steps = reader.get<std::uint64_t>();
    tally.scores = reader.get_all<std::int64_t>(objectives);
  }
  return tallies;
}

}  // namespace coppice::wire
