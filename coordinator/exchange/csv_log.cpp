#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>

#include "coordinator/exchange/log_reader.hpp"
#include "coordinator/exchange/model.hpp"
#include "coordinator/exchange/text_number.hpp"

namespace coppice {
namespace {

constexpr std::size_t kMaxColumns = 4096;
constexpr std::string_view kNextPrefix = "next_";

std::string_view without_quotes(std::string_view field) {
  field = trimmed(field);
  return field.size() >= 2 && field.front() == '"' && field.back() == '"' ? field.substr(1, field.size() - 2) : field;
}

class CsvLog : public LogReader {
 public:
  explicit CsvLog(LineReader lines) : lines_(std::move(lines)) {}

  Result<void> read_header() {
    std::string_view line;
    do {  // ends: every turn reads a line
      if (!lines_.next(line)) {
        return lines_.failed() ? Result<void>(tl::unexpected(lines_.error())) : wrong("no line: expected a header");
      }
      if (lines_.line_number() == 1 && line.substr(0, 3) == "\xEF\xBB\xBF") {
        line.remove_prefix(3);
      }
    } while (trimmed(line).empty() || line.front() == '#');
    split(line);
    if (fields_.size() > kMaxColumns) {
      return wrong(fmt::format("{} columns: expected at most {}", fields_.size(), kMaxColumns));
    }
    std::vector<std::string> names;
    names.reserve(fields_.size());
    for (const std::string_view field : fields_) {
      names.emplace_back(without_quotes(field));
    }
    columns_ = names.size();
    const auto column = [&names](std::string_view name) {
      return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    episode_ = column("episode");
    step_ = column("step");
    action_ = column("action");
    reward_ = column("reward");
    terminated_ = std::min(column("terminated"), column("done"));
    truncated_ = column("truncated");
    if (action_ == columns_ || reward_ == columns_) {
      return wrong(
          fmt::format("no column '{}': expected episode, step, the features, action, reward, next_ and each "
                      "feature, terminated, truncated",
                      action_ == columns_ ? "action" : "reward"));
    }
    return name_features(names);
  }

  Result<bool> next(LogStep& step) override {
    std::string_view line;
    do {  // ends: every turn reads a line
      if (!lines_.next(line)) {
        return lines_.failed() ? Result<bool>(tl::unexpected(lines_.error())) : Result<bool>(false);
      }
    } while (line.empty());
    split(line);
    if (fields_.size() != columns_) {
      return tl::unexpected(wrong(fmt::format("{} fields: expected {}", fields_.size(), columns_)).value());
    }
    for (std::size_t f = 0; f < observed_.size(); ++f) {
      if (!read_number(observed_[f], observation_[f])) {
        return not_a_number(observed_[f]);
      }
    }
    step.observation = observation_;
    step.next = {};
    if (!next_.empty()) {
      bool given = true;
      for (std::size_t f = 0; f < next_.size() && given; ++f) {
        given = !trimmed(fields_[next_[f]]).empty();
        if (given && !read_number(next_[f], next_observation_[f])) {
          return not_a_number(next_[f]);
        }
      }
      step.next = given ? std::span<const double>(next_observation_) : std::span<const double>();
    }
    if (!read_number(reward_, step.reward)) {
      return not_a_number(reward_);
    }
    step.episode = episode_ < columns_ ? trimmed(fields_[episode_]) : std::string_view();
    step.action = without_quotes(fields_[action_]);
    step.step.reset();
    if (step_ < columns_) {
      step.step = to_whole(trimmed(fields_[step_]));
      if (!step.step) {
        return tl::unexpected(wrong(fmt::format("step '{}': expected a whole number", fields_[step_])).value());
      }
    }
    for (const auto& [column, into] :
         {std::pair{terminated_, &step.terminated}, std::pair{truncated_, &step.truncated}}) {
      *into = false;
      if (column < columns_ && !read_flag(fields_[column], *into)) {
        return tl::unexpected(
            wrong(fmt::format("found '{}': expected true or false, 1 or 0", fields_[column].substr(0, 40))).value());
      }
    }
    return true;
  }

  const LineReader& lines() const override { return lines_; }
  const SourceHeader& header() const override { return header_; }
  const std::vector<std::string>& features() const override { return header_.features; }

 private:
  tl::unexpected<Error> wrong(const std::string& what) const {
    return bad_input(fmt::format("{}: {}", lines_.where(), what));
  }
  Result<bool> not_a_number(std::size_t column) const {
    return tl::unexpected(
        wrong(fmt::format("column {}: found '{}': expected a finite number", column + 1, fields_[column].substr(0, 40)))
            .value());
  }

  void split(std::string_view line) {
    fields_.clear();
    const char* at = line.data();
    const char* end = at + line.size();
    while (true) {  // ends: every turn takes a field
      const auto* comma = static_cast<const char*>(std::memchr(at, ',', static_cast<std::size_t>(end - at)));
      const char* stop = comma != nullptr ? comma : end;
      fields_.emplace_back(at, static_cast<std::size_t>(stop - at));
      if (comma == nullptr) {
        return;
      }
      at = comma + 1;
    }
  }

  bool read_number(std::size_t column, double& into) const {
    std::string_view field = fields_[column];
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), into);
    if (error == std::errc{} && end == field.data() + field.size()) {
      return std::isfinite(into);
    }
    field = without_quotes(field);
    bool flag = false;
    if (read_flag(field, flag)) {
      into = flag ? 1.0 : 0.0;
      return true;
    }
    const auto number = to_double(field);
    into = number.value_or(0.0);
    return number && std::isfinite(into);
  }

  static bool read_flag(std::string_view field, bool& into) {
    field = trimmed(field);
    into = field == "1" || field == "true" || field == "True" || field == "TRUE" || field == "1.0";
    return into || field == "0" || field == "false" || field == "False" || field == "FALSE" || field == "0.0" ||
           field.empty();
  }

  Result<void> name_features(const std::vector<std::string>& names) {
    std::vector<std::size_t> nexts;
    for (std::size_t c = 0; c < columns_; ++c) {
      if (c == episode_ || c == step_ || c == action_ || c == reward_ || c == terminated_ || c == truncated_ ||
          names[c] == "done") {
        continue;
      }
      if (names[c].substr(0, kNextPrefix.size()) == kNextPrefix) {
        nexts.push_back(c);
        continue;
      }
      if (std::find(header_.features.begin(), header_.features.end(), names[c]) != header_.features.end()) {
        return wrong(fmt::format("two columns '{}'", names[c]));
      }
      observed_.push_back(c);
      header_.features.push_back(names[c]);
    }
    if (observed_.empty() || observed_.size() > kMaxModelFeatures) {
      return wrong(fmt::format("{} feature columns: expected 1 to {}", observed_.size(), kMaxModelFeatures));
    }
    header_.legends.resize(observed_.size());
    for (const std::string& name : header_.features) {
      const auto found = std::find_if(nexts.begin(), nexts.end(), [&](std::size_t c) {
        return std::string_view(names[c]).substr(kNextPrefix.size()) == name;
      });
      if (found != nexts.end()) {
        next_.push_back(*found);
      }
    }
    if (next_.size() != nexts.size() || (!next_.empty() && next_.size() != observed_.size())) {
      return wrong(fmt::format("{} of {} features have a column {}: expected all or none, and no others", next_.size(),
                               observed_.size(), kNextPrefix));
    }
    observation_.resize(observed_.size());
    next_observation_.resize(next_.size());
    return {};
  }

  LineReader lines_;
  SourceHeader header_;
  std::size_t columns_ = 0;
  // Columns; columns_ where there is none.
  std::size_t episode_ = 0;
  std::size_t step_ = 0;
  std::size_t action_ = 0;
  std::size_t reward_ = 0;
  std::size_t terminated_ = 0;
  std::size_t truncated_ = 0;
  std::vector<std::size_t> observed_;
  std::vector<std::size_t> next_;
  std::vector<std::string_view> fields_;
  std::vector<double> observation_;
  std::vector<double> next_observation_;
};

}  // namespace

Result<std::unique_ptr<LogReader>> open_csv_log(const std::string& path) {
  auto lines = LineReader::open(path);
  if (!lines) {
    return tl::unexpected(lines.error());
  }
  auto log = std::make_unique<CsvLog>(std::move(*lines));
  if (auto ok = log->read_header(); !ok) {
    return tl::unexpected(ok.error());
  }
  return std::unique_ptr<LogReader>(std::move(log));
}

}  // namespace coppice
