#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "coordinator/exchange/log_reader.hpp"
#include "coordinator/exchange/model.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxDepth = 32;  // of brackets, those in texts counted, too

std::size_t depth_of(std::string_view line) {
  std::size_t depth = 0;
  std::size_t deepest = 0;
  for (const char c : line) {
    depth += c == '{' || c == '[' ? 1 : 0;
    deepest = std::max(deepest, depth);
    depth -= (c == '}' || c == ']') && depth > 0 ? 1 : 0;
  }
  return deepest;
}

class JsonLog : public LogReader {
 public:
  explicit JsonLog(LineReader lines) : lines_(std::move(lines)) {}

  Result<bool> next(LogStep& step) override {
    std::string_view line;
    do {  // ends: every turn reads a line
      if (!lines_.next(line)) {
        return lines_.failed() ? Result<bool>(tl::unexpected(lines_.error())) : Result<bool>(false);
      }
    } while (trimmed(line).empty());
    if (depth_of(line) > kMaxDepth) {
      return wrong(fmt::format("nested deeper than {}", kMaxDepth));
    }
    const Json json = Json::parse(line, nullptr, false);
    if (!json.is_object()) {
      return wrong("found no JSON object: expected one a line");
    }
    if (const auto format = json.find("format"); format != json.end()) {
      if (auto ok = read_header(json); !ok) {
        return tl::unexpected(ok.error());
      }
      return next_step(step);
    }
    return read_step(json, step);
  }

  const LineReader& lines() const override { return lines_; }
  const SourceHeader& header() const override { return header_; }
  const std::vector<std::string>& features() const override { return header_.features; }

 private:
  tl::unexpected<Error> wrong(const std::string& what) const {
    return bad_input(fmt::format("{}: {}", lines_.where(), what));
  }

  // Behind the header, which may come once.
  Result<bool> next_step(LogStep& step) {
    std::string_view line;
    if (!lines_.next(line)) {
      return lines_.failed() ? Result<bool>(tl::unexpected(lines_.error())) : Result<bool>(false);
    }
    const Json json = depth_of(line) > kMaxDepth ? Json() : Json::parse(line, nullptr, false);
    return json.is_object() && !json.contains("format") ? read_step(json, step)
                                                        : Result<bool>(wrong("expected a step behind the header"));
  }

  Result<void> read_header(const Json& json) {
    if (started_ || json["format"] != "coppice-log-1") {
      return wrong("\"format\": expected \"coppice-log-1\", in the first line only");
    }
    started_ = true;
    for (const auto& [key, value] : json.items()) {
      if (const auto read = read_header_member(key, nlohmann::json(value), header_); !read) {
        return in_context(lines_.where(), read.error());
      }
    }
    return {};
  }

  Result<bool> read_step(const Json& json, LogStep& step) {
    started_ = true;
    const auto observation = json.find("observation");
    const auto action = json.find("action");
    const auto reward = json.find("reward");
    if (observation == json.end() || action == json.end() || reward == json.end()) {
      return wrong("expected \"observation\", \"action\" and \"reward\"");
    }
    if (auto ok = read_observation("observation", *observation, observation_); !ok) {
      return tl::unexpected(ok.error());
    }
    step.observation = observation_;
    step.next = {};
    if (const auto next = json.find("next_observation"); next != json.end() && !next->is_null()) {
      if (auto ok = read_observation("next_observation", *next, next_); !ok) {
        return tl::unexpected(ok.error());
      }
      step.next = next_;
    }
    if (!reward->is_number() || !std::isfinite(reward->get<double>())) {
      return wrong("\"reward\": expected a finite number");
    }
    step.reward = reward->get<double>();
    if (!action->is_string() && !action->is_number_integer() && !action->is_boolean()) {
      return wrong("\"action\": expected a name or a whole number");
    }
    action_ = action->is_string() ? action->get<std::string>()
                                  : (action->is_boolean() ? (action->get<bool>() ? "1" : "0") : action->dump());
    step.action = action_;
    const auto episode = json.find("episode");
    if (episode != json.end() && episode->is_structured()) {
      return wrong("\"episode\": expected a number or a text");
    }
    episode_ = episode == json.end() || episode->is_null()
                   ? std::string()
                   : episode->dump(-1, ' ', false, Json::error_handler_t::replace);
    step.episode = episode_;
    step.step.reset();
    if (const auto number = json.find("step"); number != json.end() && !number->is_null()) {
      if (!number->is_number_unsigned()) {
        return wrong("\"step\": expected a whole number");
      }
      step.step = number->get<std::uint64_t>();
    }
    for (const auto& [key, into] :
         {std::pair{"terminated", &step.terminated}, std::pair{"truncated", &step.truncated}}) {
      const auto flag = json.find(key);
      if (flag != json.end() && !flag->is_boolean()) {
        return wrong(fmt::format("\"{}\": expected true or false", key));
      }
      *into = flag != json.end() && flag->get<bool>();
    }
    return true;
  }

  static bool read_number(const Json& value, double& into) {
    if (value.is_boolean()) {
      into = value.get<bool>() ? 1.0 : 0.0;
      return true;
    }
    into = value.is_number() ? value.get<double>() : 0.0;
    return value.is_number() && std::isfinite(into);
  }

  Result<void> read_observation(const char* key, const Json& value, std::vector<double>& into) {
    const Json list = value.is_array() || value.is_object() ? Json() : Json::array({value});
    const Json& readings = list.is_null() ? value : list;
    if (header_.features.empty()) {
      std::size_t number = 0;
      for (const auto& [name, reading] : readings.items()) {
        header_.features.push_back(readings.is_object() ? name : fmt::format("x{}", number++));
      }
      header_.legends.resize(header_.features.size());
    }
    if (readings.size() != header_.features.size() || readings.empty() || readings.size() > kMaxModelFeatures) {
      return wrong(fmt::format("\"{}\" has {} numbers: expected {}", key, readings.size(),
                               header_.features.empty() ? "1 or more" : std::to_string(header_.features.size())));
    }
    into.resize(readings.size());
    for (std::size_t f = 0; f < into.size(); ++f) {
      const Json* reading = nullptr;
      if (readings.is_object()) {
        const auto found = readings.find(header_.features[f]);
        reading = found == readings.end() ? nullptr : &*found;
      } else {
        reading = &readings[f];
      }
      if (reading == nullptr || !read_number(*reading, into[f])) {
        return wrong(fmt::format("\"{}\": expected a finite number for {}", key, header_.features[f]));
      }
    }
    return {};
  }

  LineReader lines_;
  SourceHeader header_;
  bool started_ = false;
  std::string episode_;
  std::string action_;
  std::vector<double> observation_;
  std::vector<double> next_;
};

}  // namespace

Result<std::unique_ptr<LogReader>> open_json_log(const std::string& path) {
  auto lines = LineReader::open(path);
  if (!lines) {
    return tl::unexpected(lines.error());
  }
  return std::unique_ptr<LogReader>(std::make_unique<JsonLog>(std::move(*lines)));
}

}  // namespace coppice
