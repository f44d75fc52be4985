// Pictures that gnuplot (http://gnuplot.info) draws: its path, its strings, its output as a whole file or none.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/error.hpp"

namespace coppice {

// A gnuplot string in single quotes, in which nothing is special but the quote itself (in double quotes, backquotes
// would run a command). Control characters become blanks.
std::string gnuplot_string(const std::string& text);

// What a picture is written as.
enum class PictureFormat : std::uint8_t { svg, png };

// The format that an extension asks for. Errors (bad_input) name the two that exist.
Result<PictureFormat> picture_format(const std::filesystem::path& path);

// "set terminal ..." for a picture of so many pixels.
std::string gnuplot_terminal(int width, int height, PictureFormat format = PictureFormat::svg);

// Error: gnuplot is not on PATH.
Result<void> check_gnuplot();

// Writes what the script draws, which appears whole or not at all. Errors: gnuplot is missing or fails; the file cannot
// be written.
Result<void> draw_by_gnuplot(const std::string& script, const std::filesystem::path& path);

}  // namespace coppice
