// A folder of a test's own and the program in it.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tests/e2e/process.hpp"
#include "tests/temporary_folder.hpp"

namespace coppice::e2e {

inline constexpr Ending kDone{0, 0};
inline constexpr Ending kFailed{1, 0};
inline constexpr Ending kWrongUse{2, 0};
inline constexpr Ending kBadInput{3, 0};
inline constexpr Ending kInterrupted{4, 0};
inline constexpr Ending kNoWorker{5, 0};
inline constexpr Ending kDamaged{6, 0};

inline const std::string kWallTree = "(selector (sequence s3=0 turn_left) move)";

class CommandLine : public ::testing::Test {
 protected:
  Command command(std::vector<std::string> arguments) const {
    return {.program = COPPICE_PROGRAM, .arguments = std::move(arguments), .folder = folder_.path(), .environment = {}};
  }
  Completed coppice(std::vector<std::string> arguments, std::string_view input = {}) const {
    return run_to_end(command(std::move(arguments)), input);
  }
  // `line` for /bin/sh, in which "$0" is the program.
  Completed shell(const std::string& line) const {
    return run_to_end({.program = "/bin/sh",
                       .arguments = {"-c", line, COPPICE_PROGRAM},
                       .folder = folder_.path(),
                       .environment = {}});
  }
  nlohmann::json coppice_json(std::vector<std::string> arguments) const {
    const Completed completed = coppice(std::move(arguments));
    EXPECT_EQ(completed.ending, kDone) << completed.error;
    return nlohmann::json::parse(completed.output, nullptr, false);
  }

  // A quickly learned policy of the default room: study.coppice.
  void learn_study() const {
    const Completed completed = coppice({"learn", "-o", "study.coppice", "--episodes", "400", "--seed", "5"});
    ASSERT_EQ(completed.ending, kDone) << completed.error;
  }

  // Wrong use or bad input: exit code 2 for what the command line says, which the line then begins with or the parser
  // says, 3 for what a file holds, 6 for a damaged study; nothing on standard output, and one line on standard error
  // that names all of `parts`.
  void expect_wrong_use(std::vector<std::string> arguments, const std::vector<std::string>& parts,
                        std::string_view input = {}) const {
    const Completed completed = coppice(std::move(arguments), input);
    const std::string& said = completed.error;
    const bool of_flag = said.rfind("coppice: -", 0) == 0 || said.find("--help)") != std::string::npos ||
                         said.find("is no command and no topic") != std::string::npos;
    const bool of_damage = said.find(": damaged: ") != std::string::npos;
    EXPECT_EQ(completed.ending, of_flag ? kWrongUse : of_damage ? kDamaged : kBadInput) << said;
    EXPECT_EQ(completed.output, "");
    EXPECT_EQ(completed.error.rfind("coppice: ", 0), 0U) << completed.error;
    EXPECT_EQ(std::count(completed.error.begin(), completed.error.end(), '\n'), 1) << completed.error;
    for (const std::string& part : parts) {
      EXPECT_NE(completed.error.find(part), std::string::npos) << "'" << part << "' is not in: " << completed.error;
    }
  }

  std::string path(const std::string& name) const { return folder_ / name; }
  bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }
  void write(const std::string& name, const std::string& content) const { std::ofstream(path(name)) << content; }
  std::string read(const std::string& name) const {
    std::ifstream in(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  testing::TemporaryFolder folder_;
};

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

}  // namespace coppice::e2e
