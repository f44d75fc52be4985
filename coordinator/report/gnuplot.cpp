#include "coordinator/report/gnuplot.hpp"

#include <fmt/format.h>

#include "coordinator/report/program.hpp"
#include "coordinator/report/whole_file.hpp"

namespace coppice {

std::string gnuplot_string(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    result += c == '\'' ? "''" : std::string(1, static_cast<unsigned char>(c) < ' ' ? ' ' : c);
  }
  return result + "'";
}

std::string gnuplot_terminal(int width, int height) {
  return fmt::format("set terminal svg size {},{} noenhanced font 'Helvetica,12' background rgb 'white'\n", width,
                     height);
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
