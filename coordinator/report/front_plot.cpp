#include "coordinator/report/front_plot.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <vector>

#include "coordinator/report/front_report.hpp"

namespace coppice {
namespace {

constexpr int kWidth = 760;
constexpr int kHeight = 480;

struct Dot {
  double x, y;            // as shown
  double cost_x, cost_y;  // to be small
  std::size_t nodes;
};

// Those that no other beats, from left to right or from right to left.
std::vector<Dot> best_of(std::vector<Dot> dots) {
  std::sort(dots.begin(), dots.end(), [](const Dot& a, const Dot& b) {
    return a.cost_x != b.cost_x ? a.cost_x < b.cost_x : a.cost_y < b.cost_y;
  });
  std::vector<Dot> best;
  for (const Dot& dot : dots) {
    if (best.empty() || dot.cost_y < best.back().cost_y) {
      best.push_back(dot);
    }
  }
  return best;
}

std::string axis(std::string_view name, Measure measure) {
  return fmt::format("set {0}label {1}\nset format {0} '%g{2}'\n", name, gnuplot_string(std::string(name_of(measure))),
                     is_share(measure) ? " %%" : "");
}

// Inline data for one "plot '-'".
std::string data_of(const std::vector<Dot>& dots) {
  std::string text;
  for (const Dot& dot : dots) {
    text += fmt::format("{} {} {}\n", dot.x, dot.y, dot.nodes);
  }
  return text + "e\n";
}

}  // namespace

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

std::string to_gnuplot(const Front& front, const FrontAxes& axes, std::optional<std::size_t> picked,
                       PictureFormat format) {
  std::vector<Dot> dots;
  for (const FrontMember& member : front.members) {
    const double x = *value_of(front, member, axes.across) * (is_share(axes.across) ? 100.0 : 1.0);
    const double y = *value_of(front, member, axes.up) * (is_share(axes.up) ? 100.0 : 1.0);
    dots.push_back({x, y, is_cost(axes.across) ? x : -x, is_cost(axes.up) ? y : -y, member.tree.size()});
  }
  std::string text = gnuplot_terminal(kWidth, kHeight, format);
  text += "set key off\nset grid\nset offsets graph 0.03, graph 0.03, graph 0.03, graph 0.03\n";
  text += "set palette defined (0 '#b8d0ff', 1 '#00206a')\nset cblabel 'nodes'\n";
  text += axis("x", axes.across) + axis("y", axes.up);
  text +=
      "plot '-' using 1:2 with lines linecolor rgb '#888888', "
      "'-' using 1:2:3 with points pointtype 7 pointsize 0.7 linecolor palette";
  text += picked ? ", '-' using 1:2 with points pointtype 6 pointsize 1.4 linewidth 2 linecolor rgb 'red'\n" : "\n";
  text += data_of(best_of(dots)) + data_of(dots);
  return picked ? text + data_of({dots[*picked]}) : text;
}

Result<void> write_front_plot(const Front& front, const FrontAxes& axes, std::optional<std::size_t> picked,
                              const std::filesystem::path& path) {
  const Result<PictureFormat> format = picture_format(path);
  if (!format) {
    return tl::unexpected(format.error());
  }
  return draw_by_gnuplot(to_gnuplot(front, axes, picked, *format), path);
}

}  // namespace coppice
