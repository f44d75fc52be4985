#include "coordinator/runs/new_folder.hpp"

#include <chrono>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <system_error>

namespace coppice {
namespace {

constexpr int kMostFolderNames = 100;  // folders of one stem that are made in the same second

}  // namespace

// std::filesystem::create_directory() makes it in one step, so that two commands cannot get the same one.
Result<std::filesystem::path> new_folder(const std::string& given, std::string_view stem) {
  std::error_code error;
  if (!given.empty()) {
    if (!std::filesystem::create_directory(given, error)) {
      return error ? failed(fmt::format("cannot make the folder {}: {}", given, error.message()))
                   : bad_input(fmt::format("-o: {} exists already: expected the name of a new folder", given));
    }
    return std::filesystem::path(given);
  }
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  const std::string first = fmt::format("{}-{:%Y%m%dT%H%M%SZ}", stem, fmt::gmtime(now));
  for (int i = 1; i <= kMostFolderNames; ++i) {
    const std::string name = i == 1 ? first : fmt::format("{}-{}", first, i);
    if (std::filesystem::create_directory(name, error)) {
      return std::filesystem::path(name);
    }
    if (error) {
      return failed(fmt::format("cannot make the folder {}: {}", name, error.message()));
    }
  }
  return failed(fmt::format("{} and {} names like it exist already", first, kMostFolderNames - 1));
}

}  // namespace coppice
