#include "coordinator/report/front_report.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/tree/text.hpp"
#include "coordinator/report/json_line.hpp"

namespace coppice {
namespace {

bool is_share(Measure measure) {
  if (!is_objective(measure)) {
    return false;
  }
  const ObjectiveKind kind = kind_of(measure);
  return kind == ObjectiveKind::agreement || kind == ObjectiveKind::coverage || kind == ObjectiveKind::visits ||
         kind == ObjectiveKind::seen;
}

// A drawing's coordinates, in pixels.
constexpr double kWidth = 720.0;
constexpr double kHeight = 480.0;
constexpr double kLeft = 70.0;
constexpr double kRight = 20.0;
constexpr double kTop = 20.0;
constexpr double kBottom = 50.0;
constexpr int kTicks = 5;
constexpr std::size_t kMostNodesShown = 40;  // darkest

// Values of one measure along one side of a drawing.
struct Scale {
  double low = 0.0;
  double high = 1.0;
  double from = 0.0;  // pixels
  double to = 1.0;

  static Scale of(const Front& front, Measure measure, double from, double to) {
    Scale scale{*value_of(front, front.members.front(), measure), 0.0, from, to};
    scale.high = scale.low;
    for (const FrontMember& member : front.members) {
      const double value = *value_of(front, member, measure);
      scale.low = std::min(scale.low, value);
      scale.high = std::max(scale.high, value);
    }
    if (scale.low == scale.high) {
      scale.low -= 0.5;
      scale.high += 0.5;
    }
    return scale;
  }
  double at(double value) const { return from + (value - low) / (high - low) * (to - from); }
};

}  // namespace

std::string measure_text(Measure measure, double value) {
  if (is_share(measure)) {
    return fmt::format("{:.1f} %", 100.0 * value);
  }
  if (!is_objective(measure)) {
    return fmt::format("{:.0f}", value);
  }
  return kind_of(measure) == ObjectiveKind::expected_return ? fmt::format("{:.1f}", value)
                                                            : fmt::format("{:.4f}", value);
}

std::string to_text(const Front& front, std::optional<std::size_t> picked) {
  constexpr std::size_t kGap = 2;
  std::vector<std::vector<std::string>> rows(1, {"#"});
  for (const Measure measure : front.measures) {
    rows[0].emplace_back(name_of(measure));
  }
  rows[0].emplace_back("fitness");
  for (std::size_t i = 0; i < front.members.size(); ++i) {
    std::vector<std::string> row = {fmt::format("{}", i)};
    for (std::size_t m = 0; m < front.measures.size(); ++m) {
      row.push_back(measure_text(front.measures[m], front.members[i].values[m]));
    }
    row.push_back(fmt::format("{:.4f}{}", front.members[i].fitness, picked == i ? " <" : "  "));
    rows.push_back(std::move(row));
  }
  rows[0].back() += "  ";
  std::string text;
  for (const std::vector<std::string>& row : rows) {
    std::string line;
    for (std::size_t column = 0; column < row.size(); ++column) {
      std::size_t width = 0;
      for (const std::vector<std::string>& other : rows) {
        width = std::max(width, other[column].size());
      }
      line += fmt::format("{:>{}}", row[column], width + (column == 0 ? 0 : kGap));
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

std::string to_json(const Front& front, const Vocabulary& vocabulary, std::optional<std::size_t> picked) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < front.members.size(); ++i) {
    const FrontMember& member = front.members[i];
    nlohmann::ordered_json json = {{"number", i}, {"picked", picked == i}, {"fitness", member.fitness}};
    for (std::size_t m = 0; m < front.measures.size(); ++m) {
      json[std::string(name_of(front.measures[m]))] = member.values[m];
    }
    json["tree"] = to_text(member.tree, vocabulary);
    list.push_back(std::move(json));
  }
  return json_line(list);
}

Result<FrontAxes> axes_from(std::string_view text, const Front& front) {
  const auto measures = measures_from(text);
  if (!measures) {
    return tl::unexpected(measures.error());
  }
  if (measures->size() != 2) {
    return bad_input(fmt::format("'{}': expected two measures, such as coverage,agreement", text));
  }
  for (const Measure measure : *measures) {
    if (std::find(front.measures.begin(), front.measures.end(), measure) == front.measures.end()) {
      return bad_input(
          fmt::format("the front has no '{}': expected two of {}", name_of(measure), to_text(front.measures)));
    }
  }
  return FrontAxes{(*measures)[0], (*measures)[1]};
}

std::string front_svg(const Front& front, const FrontAxes& axes, std::optional<std::size_t> picked) {
  const Scale across = Scale::of(front, axes.across, kLeft, kWidth - kRight);
  const Scale up = Scale::of(front, axes.up, kHeight - kBottom, kTop);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
      kWidth, kHeight);
  for (int tick = 0; tick <= kTicks; ++tick) {
    const double share = static_cast<double>(tick) / kTicks;
    const double x = across.low + share * (across.high - across.low);
    const double y = up.low + share * (up.high - up.low);
    svg += fmt::format("<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke=\"#ddd\"/>", across.at(x), kTop, kHeight - kBottom);
    svg += fmt::format("<path d=\"M{0:.1f} {1:.1f}H{2:.1f}\" stroke=\"#ddd\"/>\n", kLeft, up.at(y), kWidth - kRight);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>", across.at(x),
                       kHeight - kBottom + 16.0, measure_text(axes.across, x));
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", kLeft - 6.0, up.at(y) + 4.0,
                       measure_text(axes.up, y));
  }
  svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
                     (kLeft + kWidth - kRight) / 2.0, kHeight - 12.0, name_of(axes.across));
  svg += fmt::format("<text transform=\"translate(14 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     (kTop + kHeight - kBottom) / 2.0, name_of(axes.up));

  struct Dot {
    double x, y;            // pixels
    double cost_x, cost_y;  // to be small
  };
  std::vector<Dot> dots;
  for (std::size_t i = 0; i < front.members.size(); ++i) {
    const FrontMember& member = front.members[i];
    const double x = *value_of(front, member, axes.across);
    const double y = *value_of(front, member, axes.up);
    dots.push_back({across.at(x), up.at(y), is_cost(axes.across) ? x : -x, is_cost(axes.up) ? y : -y});
    const std::size_t dark = std::min(member.tree.size(), kMostNodesShown) * 5;
    const bool is_picked = picked == i;
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"rgb({},{},255)\"{}><title>#{}: {} "
        "nodes</title></circle>\n",
        dots.back().x, dots.back().y, is_picked ? 6 : 4, 200 - dark, 200 - dark,
        is_picked ? " stroke=\"red\" stroke-width=\"2\"" : "", i, member.tree.size());
  }
  std::sort(dots.begin(), dots.end(), [](const Dot& a, const Dot& b) {
    return a.cost_x != b.cost_x ? a.cost_x < b.cost_x : a.cost_y < b.cost_y;
  });
  std::string path;
  double least = 0.0;
  for (const Dot& dot : dots) {
    if (path.empty() || dot.cost_y < least) {
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", dot.x, dot.y);
      least = dot.cost_y;
    }
  }
  return svg + fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#888\"/>\n</svg>\n", path);
}

}  // namespace coppice
