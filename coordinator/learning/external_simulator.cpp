#include "coordinator/learning/external_simulator.hpp"

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/check.hpp"

namespace coppice {
namespace {

using SimulatorJson = nlohmann::json;

constexpr std::chrono::milliseconds kFirstLine{120'000};  // a heavy environment may take long to load
constexpr double kMaxTimeout = 3600.0;                    // seconds
constexpr std::size_t kMaxShown = 200;                    // characters of a line repeated in a message
constexpr int kProtocol = 1;

std::string shown(std::string_view line) {
  std::string text = "'";
  for (const char c : line.substr(0, kMaxShown)) {
    text += c >= ' ' && c <= '~' ? std::string(1, c) : fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  }
  return text + (line.size() > kMaxShown ? "...'" : "'");
}

// Nothing: not a list of `size` numbers, none of them NaN or infinite (JSON has no such).
std::optional<std::vector<double>> numbers_of(const SimulatorJson& json, std::size_t size) {
  if (!json.is_array() || json.size() != size) {
    return std::nullopt;
  }
  std::vector<double> numbers;
  numbers.reserve(size);
  for (const SimulatorJson& number : json) {
    if (number.is_boolean()) {
      numbers.push_back(number.get<bool>() ? 1.0 : 0.0);
    } else if (number.is_number() && std::isfinite(number.get<double>())) {
      numbers.push_back(number.get<double>());
    } else {
      return std::nullopt;
    }
  }
  return numbers;
}

std::optional<std::vector<bool>> flags_of(const SimulatorJson& json, std::size_t size) {
  if (!json.is_array() || json.size() != size) {
    return std::nullopt;
  }
  std::vector<bool> flags;
  flags.reserve(size);
  for (const SimulatorJson& flag : json) {
    if (!flag.is_boolean()) {
      return std::nullopt;
    }
    flags.push_back(flag.get<bool>());
  }
  return flags;
}

const SimulatorJson& member(const SimulatorJson& json, const char* key) {
  static const SimulatorJson none_given;
  const auto found = json.find(key);
  return found == json.end() ? none_given : *found;
}

std::optional<std::vector<std::vector<double>>> observations_of(const SimulatorJson& json, std::size_t size,
                                                                std::size_t features) {
  if (!json.is_array() || json.size() != size) {
    return std::nullopt;
  }
  std::vector<std::vector<double>> observations;
  observations.reserve(size);
  for (const SimulatorJson& each : json) {
    std::optional<std::vector<double>> numbers = numbers_of(each, features);
    if (!numbers) {
      return std::nullopt;
    }
    observations.push_back(std::move(*numbers));
  }
  return observations;
}

std::string listed(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

// Nothing: not a list of texts.
std::optional<std::vector<std::string>> names_of(const SimulatorJson& json) {
  if (!json.is_array()) {
    return std::nullopt;
  }
  std::vector<std::string> names;
  for (const SimulatorJson& name : json) {
    if (!name.is_string()) {
      return std::nullopt;
    }
    names.push_back(name.get<std::string>());
  }
  return names;
}

}  // namespace

tl::unexpected<Error> ExternalSimulator::wrong(const std::string& what, const std::string& line) {
  const std::string words = child_.last_words();
  return failed(fmt::format("simulator '{}': {}: found {}{}", command_, what, shown(line),
                            words.empty() ? "" : "; on standard error it said:" + words));
}

Result<ExternalSimulator> ExternalSimulator::start(const std::string& command, const Vocabulary& vocabulary,
                                                   const StopFlag* stop) {
  Result<ChildProcess> child = ChildProcess::start(command, stop);
  if (!child) {
    return in_context(fmt::format("simulator '{}'", command), std::move(child).error());
  }
  ExternalSimulator simulator(std::move(*child), command, vocabulary.features.size());
  const Result<std::string> line = simulator.child_.read_line(kFirstLine);
  if (!line && line.error().kind == ErrorKind::interrupted) {
    return tl::unexpected(line.error());
  }
  if (!line) {
    return in_context(fmt::format("simulator '{}': before its first line", command), line.error());
  }
  const SimulatorJson hello = SimulatorJson::parse(*line, nullptr, false);
  if (!hello.is_object() || member(hello, "coppice_simulator") != kProtocol) {
    return simulator.wrong(fmt::format("its first line: expected an object with \"coppice_simulator\": {}", kProtocol),
                           *line);
  }
  std::vector<std::string> features;
  features.reserve(vocabulary.features.size());
  for (const Feature& feature : vocabulary.features) {
    features.push_back(feature.name);
  }
  struct Names {
    const char* key;
    const std::vector<std::string>& expected;
  };
  for (const Names& names : {Names{"features", features}, Names{"actions", vocabulary.actions}}) {
    const std::optional<std::vector<std::string>> found = names_of(member(hello, names.key));
    if (!found || *found != names.expected) {
      return failed(fmt::format("simulator '{}': its {} are {}: expected those of the study, in order: {}", command,
                                names.key, found ? listed(*found) : "not a list of names", listed(names.expected)));
    }
  }
  const SimulatorJson& at_once = member(hello, "episodes");
  if (!at_once.is_null()) {
    if (!at_once.is_number_unsigned() || at_once.get<std::uint64_t>() < 1 ||
        at_once.get<std::uint64_t>() > kMaxSimulatedAtOnce) {
      return simulator.wrong(fmt::format("\"episodes\": expected a whole number, 1 to {}", kMaxSimulatedAtOnce), *line);
    }
    simulator.at_once_ = at_once.get<std::uint32_t>();
  }
  const SimulatorJson& timeout = member(hello, "timeout");
  if (!timeout.is_null()) {
    if (!timeout.is_number() || !(timeout.get<double>() > 0.0 && timeout.get<double>() <= kMaxTimeout)) {
      return simulator.wrong(fmt::format("\"timeout\": expected seconds, up to {}", kMaxTimeout), *line);
    }
    simulator.timeout_ = std::chrono::milliseconds(static_cast<std::int64_t>(timeout.get<double>() * 1000.0));
  }
  simulator.tells_collisions_ = member(hello, "collisions") == true;
  return simulator;
}

Result<std::string> ExternalSimulator::ask(const std::string& request) {
  const Result<void> asked = child_.write_line(request, timeout_);
  Result<std::string> line = asked ? child_.read_line(timeout_) : tl::unexpected<Error>(asked.error());
  if (!line && line.error().kind != ErrorKind::interrupted) {
    return in_context(fmt::format("simulator '{}'", command_), std::move(line).error());
  }
  return line;
}

Result<std::string> ExternalSimulator::answer_to(const nlohmann::json& request, nlohmann::json& answer) {
  Result<std::string> line = ask(request.dump());
  if (!line) {
    return line;
  }
  answer = SimulatorJson::parse(*line, nullptr, false);
  if (!answer.is_object() || member(answer, "id") != id_) {
    return wrong(fmt::format("expected an answer with \"id\": {}", id_), *line);
  }
  if (const SimulatorJson& error = member(answer, "error"); error.is_string()) {
    return wrong("an error", error.get<std::string>());
  }
  return line;
}

Result<std::vector<std::vector<double>>> ExternalSimulator::reset(std::span<const std::uint32_t> places,
                                                                  std::span<const std::uint64_t> seeds) {
  const SimulatorJson request = {{"id", ++id_}, {"reset", places}, {"seeds", seeds}};
  SimulatorJson answer;
  const Result<std::string> line = answer_to(request, answer);
  if (!line) {
    return tl::unexpected(line.error());
  }
  auto observations = observations_of(member(answer, "observations"), places.size(), features_);
  if (!observations) {
    return wrong(fmt::format("\"observations\": expected {} lists of {} numbers", places.size(), features_), *line);
  }
  return *std::move(observations);
}

Result<std::vector<ExternalSimulator::Step>> ExternalSimulator::step(std::span<const std::uint32_t> places,
                                                                     std::span<const ActionId> actions) {
  COPPICE_CHECK(places.size() == actions.size());
  std::vector<std::size_t> indices;
  for (const ActionId action : actions) {
    indices.push_back(index_of(action));
  }
  const SimulatorJson request = {{"id", ++id_}, {"step", places}, {"actions", indices}};
  SimulatorJson answer;
  const Result<std::string> line = answer_to(request, answer);
  if (!line) {
    return tl::unexpected(line.error());
  }
  auto observations = observations_of(member(answer, "observations"), places.size(), features_);
  const auto rewards = numbers_of(member(answer, "rewards"), places.size());
  const auto terminated = flags_of(member(answer, "terminated"), places.size());
  const auto truncated = flags_of(member(answer, "truncated"), places.size());
  const auto collisions = tells_collisions_ ? flags_of(member(answer, "collisions"), places.size())
                                            : std::optional(std::vector<bool>(places.size(), false));
  if (!observations || !rewards || !terminated || !truncated || !collisions) {
    const char* which = !observations ? "observations"
                        : !rewards    ? "rewards"
                        : !terminated ? "terminated"
                        : !truncated  ? "truncated"
                                      : "collisions";
    return wrong(fmt::format("\"{}\": expected a list of {}{}", which, places.size(),
                             !observations ? fmt::format(", each of {} numbers", features_)
                             : !rewards    ? " numbers"
                                           : " booleans"),
                 *line);
  }
  std::vector<Step> steps;
  steps.reserve(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    steps.push_back(
        {std::move((*observations)[i]), (*rewards)[i], (*terminated)[i], (*truncated)[i], (*collisions)[i]});
  }
  return steps;
}

}  // namespace coppice
