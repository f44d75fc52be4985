// A front of trees as a picture of two of its measures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/error.hpp"
#include "coordinator/evolution/pick.hpp"
#include "coordinator/report/gnuplot.hpp"

namespace coppice {

struct FrontAxes {
  Measure across{};
  Measure up{};
};

// "coverage,return". Errors: not two measures, or one that the front does not have.
Result<FrontAxes> axes_from(std::string_view text, const Front& front);

// What gnuplot is told, without where to: a dot a tree, the darker the more nodes; `picked` in a circle; those that no
// other beats in these two measures are joined. REQUIRES: front.members not empty, axes of its measures.
std::string to_gnuplot(const Front& front, const FrontAxes& axes, std::optional<std::size_t> picked,
                       PictureFormat format = PictureFormat::svg);

// Writes it in the format of the path's extension. Errors: as picture_format(), draw_by_gnuplot().
Result<void> write_front_plot(const Front& front, const FrontAxes& axes, std::optional<std::size_t> picked,
                              const std::filesystem::path& path);

}  // namespace coppice
