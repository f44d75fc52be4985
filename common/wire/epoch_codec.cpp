#include "common/wire/epoch_codec.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <type_traits>
#include <utility>

#include "common/check.hpp"
#include "common/evolution/config_keys.hpp"
#include "common/evolution/migration.hpp"
#include "common/wire/node_layout.hpp"

namespace coppice::wire {
namespace {

constexpr std::uint64_t kGroup = 0x7F;
constexpr unsigned kGroupBits = 7;
constexpr std::uint8_t kMore = 0x80;
constexpr std::size_t kMostVarBytes = 10;
constexpr std::size_t kLeastIndividualBytes = 7;  // a tree of one node, and a tally without scores
constexpr std::size_t kRecordBytes = 5 * sizeof(double) + 3 * sizeof(std::uint32_t);

bool travels(const ConfigKey& key, bool with_founders) {
  return key.full_name() != "front.pick" && (with_founders || key.full_name() != "ga.founders");
}

// Appends to bytes that grow by whole payloads: no call for each number.
class EpochWriter {
 public:
  template <typename T>
  void put(T value) {
    std::array<std::uint8_t, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
  }
  void put_var(std::uint64_t value) {
    for (; value > kGroup; value >>= kGroupBits) {
      bytes_.push_back(static_cast<std::uint8_t>((value & kGroup) | kMore));
    }
    bytes_.push_back(static_cast<std::uint8_t>(value));
  }
  void put_zig(std::int64_t value) {
    put_var((static_cast<std::uint64_t>(value) << 1U) ^ static_cast<std::uint64_t>(value >> 63));
  }
  void put_text(const std::string& text) {
    COPPICE_CHECK(text.size() < (1U << 16U));
    put(static_cast<std::uint16_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }
  void put_tree(const Tree& tree) {
    const std::size_t begin = bytes_.size();
    bytes_.resize(begin + 2 + 3 * tree.size() + kWord);
    const std::uint8_t* const end = write_tree(tree, bytes_.data() + begin);
    bytes_.resize(static_cast<std::size_t>(end - bytes_.data()));
  }
  void put_individuals(const std::vector<Individual>& individuals) {
    put(static_cast<std::uint32_t>(individuals.size()));
    for (const Individual& individual : individuals) {
      put_tree(individual.tree);
      put_var(individual.tally.nodes);
      put_var(individual.tally.matches);
      put_var(individual.tally.steps);
      for (const std::int64_t score : individual.tally.scores) {
        put_zig(score);
      }
    }
  }
  void put_deme(const Deme& deme) {
    put(deme.generations);
    put_individuals(deme.population);
    put_individuals(deme.archive);
  }
  void put_bytes(std::span<const std::uint8_t> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }

  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
};

template <typename T>
bool take(std::span<const std::uint8_t>& bytes, T& value) {
  if (bytes.size() < sizeof(T)) {
    return false;
  }
  std::memcpy(&value, bytes.data(), sizeof(T));
  bytes = bytes.subspan(sizeof(T));
  return true;
}

bool take_var(std::span<const std::uint8_t>& bytes, std::uint64_t& value) {
  value = 0;
  for (std::size_t i = 0; i < std::min(bytes.size(), kMostVarBytes); ++i) {
    const std::uint64_t group = bytes[i] & kGroup;
    const auto shift = static_cast<unsigned>(i) * kGroupBits;
    if (shift == 63 && group > 1) {
      return false;
    }
    value |= group << shift;
    if ((bytes[i] & kMore) == 0) {
      const bool spare = i > 0 && group == 0;
      bytes = bytes.subspan(i + 1);
      return !spare;
    }
  }
  return false;
}

bool take_zig(std::span<const std::uint8_t>& bytes, std::int64_t& value) {
  std::uint64_t raw = 0;
  const bool ok = take_var(bytes, raw);
  value = static_cast<std::int64_t>((raw >> 1U) ^ (0 - (raw & 1U)));
  return ok;
}

bool take_text(std::span<const std::uint8_t>& bytes, std::string& text) {
  std::uint16_t size = 0;
  if (!take(bytes, size) || bytes.size() < size) {
    return false;
  }
  text.assign(bytes.begin(), bytes.begin() + size);
  bytes = bytes.subspan(size);
  return true;
}

tl::unexpected<Error> cut_short(const char* what) {
  return bad_input(fmt::format("{} is cut short, or a number in it is not as it is written", what));
}

Result<void> take_key(std::span<const std::uint8_t>& bytes, const ConfigKey& key) {
  return std::visit(
      [&](const auto& now) -> Result<void> {
        std::decay_t<decltype(now)> value{};
        bool ok = false;
        if constexpr (std::is_same_v<decltype(value), std::string>) {
          ok = take_text(bytes, value);
        } else if constexpr (!std::is_same_v<decltype(value), OtherValue>) {
          ok = take(bytes, value);
        }
        return ok ? assign(key, value) : cut_short("configuration");
      },
      value_of(key));
}

Result<EvolveConfig> take_configuration(std::span<const std::uint8_t> bytes) {
  EvolveConfig config;
  std::uint8_t with_founders = 0;
  if (!take(bytes, with_founders) || with_founders > 1) {
    return cut_short("configuration");
  }
  for (const ConfigKey& key : keys_of(config)) {
    if (travels(key, with_founders == 1)) {
      if (auto ok = take_key(bytes, key); !ok) {
        return tl::unexpected(ok.error());
      }
    }
  }
  std::uint8_t rules = 0;
  if (!take(bytes, rules)) {
    return cut_short("configuration");
  }
  for (std::uint8_t i = 0; i < rules; ++i) {
    RuleConfig rule;
    std::uint8_t conditions = 0;
    if (!take(bytes, rule.right) || !take(bytes, rule.wrong) || !take(bytes, conditions)) {
      return cut_short("rule");
    }
    for (const ConfigKey& key : keys_of(rule)) {
      if (auto ok = assign(key, value_of(key)); !ok) {
        return tl::unexpected(ok.error());
      }
    }
    for (std::uint8_t j = 0; j < conditions; ++j) {
      rule.any_of.emplace_back();
      if (!take_text(bytes, rule.any_of.back())) {
        return cut_short("rule");
      }
    }
    config.fitness.rules.push_back(std::move(rule));
  }
  if (!bytes.empty()) {
    return bad_input(fmt::format("{} bytes follow the configuration", bytes.size()));
  }
  return config;
}

std::size_t most_nodes(const GaConfig& ga) {
  std::size_t nodes = 1;
  std::size_t level = 1;
  for (std::uint32_t depth = 0; depth < ga.max_depth && nodes < ga.max_nodes; ++depth) {
    level *= ga.max_children;
    nodes += level;
  }
  return std::min<std::size_t>(nodes, ga.max_nodes);
}

}  // namespace

std::vector<std::uint8_t> encode_configuration(const EvolveConfig& config, bool with_founders) {
  EvolveConfig copy = config;
  EpochWriter writer;
  writer.put(std::uint8_t{with_founders});
  for (const ConfigKey& key : keys_of(copy)) {
    if (travels(key, with_founders)) {
      std::visit(
          [&](const auto& value) {
            using V = std::decay_t<decltype(value)>;
            if constexpr (std::is_same_v<V, std::string>) {
              writer.put_text(value);
            } else if constexpr (!std::is_same_v<V, OtherValue>) {
              writer.put(value);
            }
          },
          value_of(key));
    }
  }
  writer.put(static_cast<std::uint8_t>(config.fitness.rules.size()));
  for (const RuleConfig& rule : config.fitness.rules) {
    writer.put(rule.right);
    writer.put(rule.wrong);
    writer.put(static_cast<std::uint8_t>(rule.any_of.size()));
    for (const std::string& condition : rule.any_of) {
      writer.put_text(condition);
    }
  }
  return writer.take();
}

std::vector<std::uint8_t> encode_epoch_task(std::span<const std::uint8_t> configuration, const EpochTask& task) {
  EpochWriter writer;
  writer.put(static_cast<std::uint32_t>(configuration.size()));
  writer.put_bytes(configuration);
  writer.put(task.number);
  writer.put(task.until);
  writer.put(std::uint8_t{task.count_meanings});
  writer.put(std::uint8_t{task.deme == nullptr});
  if (task.deme) {
    writer.put_deme(*task.deme);
    writer.put_individuals(task.migrants);
  }
  return writer.take();
}

std::vector<std::uint8_t> encode_epoch_result(const EpochResult& result) {
  EpochWriter writer;
  writer.put_deme(result.deme);
  writer.put_individuals(result.emigrants);
  writer.put(static_cast<std::uint32_t>(result.records.size()));
  for (const GenerationRecord& record : result.records) {
    writer.put_tree(record.best.tree);
    for (const double value :
         {record.best.fitness, record.best.agreement, record.mean_fitness, record.mean_agreement, record.mean_nodes}) {
      writer.put(value);
    }
    writer.put(record.distinct_trees);
    writer.put(record.meanings);
    writer.put(static_cast<std::uint32_t>(record.evaluations));
  }
  return writer.take();
}

std::size_t most_epoch_bytes(const EvolveConfig& config, std::size_t objectives) {
  const GaConfig& ga = config.ga;
  const std::size_t tree = 2 + 3 * most_nodes(ga);
  const std::size_t individuals =
      share_of(ga, 0).size + 2 * std::size_t{ga.migrants} + (ga.search == Search::front ? config.front.members : 0);
  const std::size_t configuration =
      std::max(encode_configuration(config, true).size(), std::size_t{epoch_length(ga)} * (tree + kRecordBytes));
  return 64 + configuration + individuals * (tree + (3 + objectives) * kMostVarBytes);
}

Result<DecodedEpoch> EpochDecoder::decode_task(std::span<const std::uint8_t> payload) {
  std::uint32_t size = 0;
  if (!take(payload, size) || payload.size() < size) {
    return cut_short("task");
  }
  if (auto ok = read_configuration(payload.first(size)); !ok) {
    return in_context("configuration", ok.error());
  }
  payload = payload.subspan(size);
  DecodedEpoch epoch{config_, {}};
  std::uint8_t meanings = 0;
  std::uint8_t begins = 0;
  if (!take(payload, epoch.task.number) || !take(payload, epoch.task.until) || !take(payload, meanings) ||
      meanings > 1 || !take(payload, begins) || begins > 1) {
    return cut_short("task");
  }
  if (configuration_.front() != begins) {
    return bad_input("founders travel with demes that begin, and with no others");
  }
  epoch.task.count_meanings = meanings == 1;
  if (begins == 0) {
    auto deme = read_deme(payload);
    if (!deme) {
      return tl::unexpected(deme.error());
    }
    auto migrants = read_individuals(payload);
    if (!migrants) {
      return in_context("migrants", migrants.error());
    }
    epoch.task.deme = std::make_shared<const Deme>(std::move(*deme));
    epoch.task.migrants = std::move(*migrants);
  }
  if (!payload.empty()) {
    return bad_input(fmt::format("{} bytes follow the task", payload.size()));
  }
  if (auto ok = check_->task(epoch.task); !ok) {
    return tl::unexpected(ok.error());
  }
  return epoch;
}

Result<EpochResult> EpochDecoder::decode_result(std::span<const std::uint8_t> payload,
                                                const std::shared_ptr<const EvolveConfig>& config,
                                                const EpochTask& task) {
  if (config_ == nullptr || *config_ != *config) {
    use(config);
    configuration_.clear();
  }
  EpochResult result;
  auto deme = read_deme(payload);
  if (!deme) {
    return tl::unexpected(deme.error());
  }
  auto emigrants = read_individuals(payload);
  if (!emigrants) {
    return in_context("emigrants", emigrants.error());
  }
  const std::uint32_t begin = task.deme ? task.deme->generations : 0;
  std::uint32_t records = 0;
  if (!take(payload, records) || records != task.until - begin) {
    return bad_input(fmt::format("{} records: expected {}", records, task.until - begin));
  }
  for (std::uint32_t i = 0; i < records; ++i) {
    auto tree = read_tree(payload);
    if (!tree) {
      return in_context(fmt::format("record {}", i), tree.error());
    }
    GenerationRecord record{.generation = begin + i,
                            .best = {std::move(*tree), begin + i, 0.0, 0.0},
                            .mean_fitness = 0.0,
                            .mean_agreement = 0.0,
                            .mean_nodes = 0.0,
                            .distinct_trees = 0,
                            .meanings = 0,
                            .evaluations = 0,
                            .seconds = 0.0};
    for (double* const value : {&record.best.fitness, &record.best.agreement, &record.mean_fitness,
                                &record.mean_agreement, &record.mean_nodes}) {
      if (!take(payload, *value) || !std::isfinite(*value)) {
        return bad_input(fmt::format("record {}: expected a finite number", i));
      }
    }
    std::uint32_t evaluations = 0;
    if (!take(payload, record.distinct_trees) || !take(payload, record.meanings) || !take(payload, evaluations)) {
      return cut_short("record");
    }
    record.evaluations = evaluations;
    result.records.push_back(std::move(record));
  }
  if (!payload.empty()) {
    return bad_input(fmt::format("{} bytes follow the result", payload.size()));
  }
  result.deme = std::move(*deme);
  result.emigrants = std::move(*emigrants);
  if (auto ok = check_->result(result, task); !ok) {
    return tl::unexpected(ok.error());
  }
  return result;
}

Result<void> EpochDecoder::read_configuration(std::span<const std::uint8_t> bytes) {
  if (!configuration_.empty() && std::ranges::equal(bytes, configuration_)) {
    return {};
  }
  auto config = take_configuration(bytes);
  if (!config) {
    return tl::unexpected(config.error());
  }
  if (auto ok = check_search(*config, chain_.vocabulary()); !ok) {
    return ok;
  }
  if (const auto again = encode_configuration(*config, bytes.front() == 1);
      !std::equal(again.begin(), again.end(), bytes.begin(), bytes.end())) {
    return bad_input("a text in it is not as it is written");
  }
  configuration_.assign(bytes.begin(), bytes.end());
  use(std::make_shared<const EvolveConfig>(std::move(*config)));
  return {};
}

void EpochDecoder::use(std::shared_ptr<const EvolveConfig> config) {
  config_ = std::move(config);
  check_.emplace(chain_, *config_);
}

Result<Tree> EpochDecoder::read_tree(std::span<const std::uint8_t>& bytes) {
  std::vector<Node> nodes;
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

Result<std::vector<Individual>> EpochDecoder::read_individuals(std::span<const std::uint8_t>& bytes) {
  std::uint32_t count = 0;
  if (!take(bytes, count) || count > bytes.size() / kLeastIndividualBytes) {
    return cut_short("list of individuals");
  }
  std::vector<Individual> individuals;
  individuals.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    auto tree = read_tree(bytes);
    if (!tree) {
      return in_context(fmt::format("individual {}", i), tree.error());
    }
    Tally tally;
    std::uint64_t nodes = 0;
    bool ok = take_var(bytes, nodes) && take_var(bytes, tally.matches) && take_var(bytes, tally.steps) &&
              nodes <= kMaxTreeNodes && tally.matches <= tally.steps;
    tally.nodes = static_cast<std::uint32_t>(nodes);
    tally.scores.resize(ok ? check_->objectives() : 0);
    for (std::int64_t& score : tally.scores) {
      ok = ok && take_zig(bytes, score);
    }
    if (!ok) {
      return cut_short("tally");
    }
    individuals.push_back({std::move(*tree), std::move(tally)});
  }
  return individuals;
}

Result<Deme> EpochDecoder::read_deme(std::span<const std::uint8_t>& bytes) {
  Deme deme;
  if (!take(bytes, deme.generations)) {
    return cut_short("deme");
  }
  auto population = read_individuals(bytes);
  if (!population) {
    return in_context("population", population.error());
  }
  auto archive = read_individuals(bytes);
  if (!archive) {
    return in_context("archive", archive.error());
  }
  deme.population = std::move(*population);
  deme.archive = std::move(*archive);
  return deme;
}

}  // namespace coppice::wire
