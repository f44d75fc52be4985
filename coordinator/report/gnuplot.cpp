#include "coordinator/report/gnuplot.hpp"

#include <fmt/format.h>

#include "coordinator/console/subprocess.hpp"
#include "coordinator/console/whole_file.hpp"

namespace coppice {

std::string gnuplot_string(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    result += c == '\'' ? "''" : std::string(1, static_cast<unsigned char>(c) < ' ' ? ' ' : c);
  }
  return result + "'";
}

Result<PictureFormat> picture_format(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".svg") {
    return PictureFormat::svg;
  }
  if (extension == ".png") {
    return PictureFormat::png;
  }
  return bad_input(fmt::format("{}: picture has extension '{}': expected .svg or .png", path.string(), extension));
}

std::string gnuplot_terminal(int width, int height, PictureFormat format) {
  return fmt::format("set terminal {} size {},{} noenhanced font 'Helvetica,12' background rgb 'white'\n",
                     format == PictureFormat::svg ? "svg" : "pngcairo", width, height);
}

Result<void> check_gnuplot() {
  return has_program("gnuplot") ? Result<void>() : failed("the program 'gnuplot' is not on PATH: install gnuplot-nox");
}

Result<void> draw_by_gnuplot(const std::string& script, const std::filesystem::path& path) {
  if (auto found = check_gnuplot(); !found) {
    return found;
  }
  return produce_whole_file(path, [&](const std::filesystem::path& temporary) {
    return run_program({"gnuplot"}, fmt::format("set output {}\n{}", gnuplot_string(temporary.string()), script));
  });
}

}  // namespace coppice
