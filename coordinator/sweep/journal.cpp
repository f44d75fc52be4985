#include "coordinator/sweep/journal.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <unistd.h>
#include <utility>

#include "common/tree/text.hpp"
#include "coordinator/console/json_line.hpp"
#include "coordinator/evolution/config_text.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const SweepResult& result, const Vocabulary& vocabulary) {
  Json json = {{"fitness", result.fitness},
               {"agreement", result.agreement},
               {"coverage", result.coverage},
               {"distinct", result.distinct},
               {"meanings", result.meanings},
               {"nodes", result.nodes},
               {"tree", to_text(result.tree, vocabulary)},
               {"seconds", result.seconds}};
  if (result.simulated) {
    json["simulated"] = {{"agreement", result.simulated->agreement},
                         {"reward", result.simulated->reward},
                         {"collisions", result.simulated->collisions}};
  }
  return json;
}

// Throws nlohmann's exceptions where something is missing or of another type.
std::optional<SweepResult> result_of(const Json& json, const Vocabulary& vocabulary) {
  const auto tree = parse_tree(json.at("tree").get<std::string>(), vocabulary);
  if (!tree) {
    return std::nullopt;
  }
  SweepResult result;
  result.fitness = json.at("fitness").get<double>();
  result.agreement = json.at("agreement").get<double>();
  result.coverage = json.at("coverage").get<double>();
  result.distinct = json.at("distinct").get<double>();
  result.meanings = json.at("meanings").get<double>();
  result.nodes = json.at("nodes").get<std::uint64_t>();
  result.tree = *tree;
  result.seconds = json.at("seconds").get<double>();
  if (json.contains("simulated")) {
    const Json& simulated = json.at("simulated");
    result.simulated =
        SweepResult::Simulated{simulated.at("agreement").get<double>(), simulated.at("reward").get<double>(),
                               simulated.at("collisions").get<double>()};
  }
  return result;
}

std::string key(const std::string& chain, std::uint64_t episodes, const EvolveConfig& config) {
  return fmt::format("{} {} {}", chain, episodes, config_to_json(config));
}

tl::unexpected<Error> cannot(const char* what, const std::filesystem::path& path) {
  return failed(fmt::format("{}: cannot be {}: {}", path.string(), what, std::strerror(errno)));
}

}  // namespace

SweepJournal::SweepJournal(std::filesystem::path path, const ChainHash& chain, std::uint64_t episodes,
                           const Vocabulary& vocabulary)
    : path_(std::move(path)), chain_(chain.hex()), episodes_(episodes), vocabulary_(vocabulary) {}

SweepJournal::SweepJournal(SweepJournal&& other) noexcept
    : path_(std::move(other.path_)),
      chain_(std::move(other.chain_)),
      episodes_(other.episodes_),
      vocabulary_(std::move(other.vocabulary_)),
      results_(std::move(other.results_)),
      lines_(std::move(other.lines_)),
      added_(std::move(other.added_)),
      file_(std::exchange(other.file_, -1)) {}

SweepJournal::~SweepJournal() {
  if (file_ >= 0) {
    close(file_);
  }
}

std::string SweepJournal::key_of(const EvolveConfig& config) const { return key(chain_, episodes_, config); }

void SweepJournal::read(const std::string& text) {
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    try {
      const Json json = Json::parse(line);
      const auto config = config_from_json(json.at("config").dump());
      if (!config) {
        continue;
      }
      const std::string run =
          key(json.at("chain").get<std::string>(), json.at("episodes").get<std::uint64_t>(), *config);
      if (json.value("revoked", false)) {
        lines_.erase(run);
        results_.erase(run);
        continue;
      }
      lines_.emplace(run, number);
      if (run != key_of(*config)) {
        continue;
      }
      if (auto result = result_of(json, vocabulary_); result) {
        results_.insert_or_assign(run, std::move(*result));
      }
    } catch (const Json::exception&) {  // NOLINT(bugprone-empty-catch): cut short, or of another program: its run is
                                        // repeated
    }
  }
}

Result<SweepJournal> SweepJournal::open(const std::filesystem::path& path, const ChainHash& chain,
                                        std::uint64_t episodes, const Vocabulary& vocabulary) {
  SweepJournal journal(path, chain, episodes, vocabulary);
  bool cut_short = false;
  if (std::filesystem::exists(path)) {
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file.is_open() || file.bad()) {
      return cannot("read", path);
    }
    journal.read(text);
    cut_short = !text.empty() && text.back() != '\n';
  }
  journal.file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (journal.file_ < 0 || (cut_short && ::write(journal.file_, "\n", 1) != 1)) {
    return cannot("written", path);
  }
  return journal;
}

const SweepResult* SweepJournal::find(const EvolveConfig& config) const {
  const auto found = results_.find(key_of(config));
  return found == results_.end() ? nullptr : &found->second;
}

std::optional<std::size_t> SweepJournal::line_beside(const std::vector<SweepRun>& runs) const {
  std::set<std::string> known;
  for (const SweepRun& run : runs) {
    known.insert(key_of(run.config));
  }
  std::optional<std::size_t> first;
  for (const auto& [run, line] : lines_) {
    if (known.count(run) == 0 && line < first.value_or(line + 1)) {
      first = line;
    }
  }
  return first;
}

Result<void> SweepJournal::add(const EvolveConfig& config, const SweepResult& result) {
  Json json = {{"chain", chain_}, {"episodes", episodes_}, {"config", Json::parse(config_to_json(config))}};
  json.update(json_of(result, vocabulary_));
  if (auto ok = write_line(json_line(json)); !ok) {
    return ok;
  }
  results_.insert_or_assign(key_of(config), result);
  added_.push_back(config);
  return {};
}

Result<std::size_t> SweepJournal::revoke_added() {
  for (const EvolveConfig& config : added_) {
    const Json json = {
        {"chain", chain_}, {"episodes", episodes_}, {"config", Json::parse(config_to_json(config))}, {"revoked", true}};
    if (auto ok = write_line(json_line(json)); !ok) {
      return tl::unexpected(ok.error());
    }
    results_.erase(key_of(config));
  }
  const std::size_t revoked = added_.size();
  added_.clear();
  return revoked;
}

// In one write: a line is there whole, or is the last and cut short.
Result<void> SweepJournal::write_line(const std::string& line) const {
  const std::string whole = line + "\n";
  if (::write(file_, whole.data(), whole.size()) != static_cast<ssize_t>(whole.size()) || fdatasync(file_) != 0) {
    return cannot("written", path_);
  }
  return {};
}

}  // namespace coppice
