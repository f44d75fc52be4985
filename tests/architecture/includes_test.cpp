// The arrows between the folders, held against every #include: who may know whom. A folder that is not listed, or an
// include that breaks an arrow, fails the test.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

// A line a folder: it, and the project folders that it may include besides itself, "common" being the files right
// inside it and open to all.
constexpr const char* kArrows = R"(
common
common/tree
common/chain           common/tree
common/fitness         common/tree common/chain
common/evolution       common/tree common/chain common/fitness
common/wire            common/tree common/chain common/fitness common/evolution
common/metrics
worker                 common/tree common/chain common/fitness common/evolution common/wire common/metrics
coordinator/console
coordinator/learning   common/tree common/chain
coordinator/problem    common/tree
coordinator/exchange   common/tree common/chain coordinator/problem
coordinator/dispatch   common/tree common/chain common/fitness common/evolution
coordinator/metrics    common/evolution common/metrics coordinator/dispatch
coordinator/fleet      common/metrics coordinator/metrics common/tree common/chain common/fitness common/evolution common/wire coordinator/dispatch
coordinator/bench      common/tree common/chain common/fitness common/evolution coordinator/evolution coordinator/dispatch coordinator/fleet coordinator/console
coordinator/evolution  common/tree common/chain common/fitness common/evolution coordinator/dispatch
coordinator/study      common/tree common/chain common/fitness common/evolution coordinator/learning coordinator/evolution coordinator/problem
coordinator/report     common/tree common/chain common/fitness coordinator/learning coordinator/evolution coordinator/study coordinator/dispatch coordinator/problem coordinator/console
coordinator/trust      common/tree common/chain coordinator/learning coordinator/report coordinator/problem coordinator/console
coordinator/refine     common/tree common/chain common/evolution coordinator/learning coordinator/evolution coordinator/study coordinator/report coordinator/console
coordinator/reproduce  common/tree common/chain common/evolution coordinator/learning coordinator/evolution coordinator/dispatch coordinator/fleet coordinator/study coordinator/report coordinator/trust coordinator/console
coordinator/sweep      common/tree common/chain common/fitness common/evolution coordinator/learning coordinator/dispatch coordinator/evolution coordinator/report coordinator/console
coordinator/runs       coordinator/metrics common/tree common/chain common/fitness common/evolution coordinator/learning coordinator/dispatch coordinator/fleet coordinator/evolution coordinator/study coordinator/report coordinator/sweep coordinator/problem coordinator/exchange coordinator/console
coordinator/studio     coordinator/problem coordinator/exchange common/tree common/chain common/evolution coordinator/learning coordinator/evolution coordinator/study coordinator/report coordinator/trust coordinator/console
coordinator/commands   common/metrics coordinator/metrics common/tree common/chain common/fitness common/evolution coordinator coordinator/learning coordinator/dispatch coordinator/fleet coordinator/bench coordinator/evolution coordinator/study coordinator/report coordinator/sweep coordinator/trust coordinator/refine coordinator/reproduce coordinator/runs coordinator/studio coordinator/console coordinator/problem coordinator/exchange
coordinator            coordinator/commands coordinator/console
)";

std::map<std::string, std::set<std::string>> arrows() {
  std::map<std::string, std::set<std::string>> arrows;
  std::istringstream lines(kArrows);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string folder;
    if (words >> folder) {
      std::set<std::string>& known = arrows[folder];
      known = {std::istream_iterator<std::string>(words), {}};
      known.insert("common");
    }
  }
  return arrows;
}

struct Include {
  std::string file;
  std::string folder;
  std::string target;
  bool quoted = false;
};

std::string folder_of(const std::string& file) { return fs::path(file).parent_path().generic_string(); }

std::vector<Include> all_includes() {
  const std::regex directive(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::vector<Include> includes;
  for (const char* top : {"common", "coordinator", "worker"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(COPPICE_SOURCE_DIR) / top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".hpp" && extension != ".cpp" && extension != ".in") {
        continue;
      }
      const std::string file = fs::relative(entry.path(), COPPICE_SOURCE_DIR).generic_string();
      std::ifstream stream(entry.path());
      std::smatch match;
      for (std::string line; std::getline(stream, line);) {
        if (std::regex_search(line, match, directive)) {
          includes.push_back({file, folder_of(file), match[2], match[1] == "\""});
        }
      }
    }
  }
  return includes;
}

TEST(Architecture, EveryIncludeFollowsAnArrow) {
  const auto includes = all_includes();
  ASSERT_GT(includes.size(), 100U);
  const auto allowed = arrows();
  for (const Include& include : includes) {
    if (!include.quoted) {
      continue;
    }
    const auto from = allowed.find(include.folder);
    ASSERT_NE(from, allowed.end()) << include.folder << " has no arrows: add it to this test";
    const std::string target = folder_of(include.target);
    EXPECT_TRUE(target == include.folder || from->second.count(target) != 0)
        << include.file << " includes " << include.target;
  }
}

TEST(Architecture, OnlyWireIncludesDds) {
  for (const Include& include : all_includes()) {
    if (!include.quoted && (include.target.rfind("dds/", 0) == 0 || include.target == "coppice.h")) {
      EXPECT_EQ(include.folder, "common/wire") << include.file;
    }
  }
}

// The bare transport that `bench` measures lives on the fleet's endpoints, and gets the wire's types from there.
TEST(Architecture, InTheCoordinatorOnlyTheFleetKnowsTheWire) {
  for (const Include& include : all_includes()) {
    if (include.quoted && folder_of(include.target) == "common/wire" && include.folder != "worker" &&
        include.folder != "common/wire") {
      EXPECT_EQ(include.folder, "coordinator/fleet") << include.file;
    }
  }
}

TEST(Architecture, OnlyExactUsesSparseSolvers) {
  for (const Include& include : all_includes()) {
    if (!include.quoted && include.target.rfind("Eigen/", 0) == 0) {
      EXPECT_EQ(include.file.rfind("common/chain/exact", 0), 0U) << include.file;
    }
  }
}

TEST(Architecture, CoordinatorAndWorkerNeverIncludeEachOther) {
  for (const Include& include : all_includes()) {
    const bool from_worker = include.folder == "worker";
    EXPECT_FALSE(from_worker && include.target.rfind("coordinator/", 0) == 0) << include.file;
    EXPECT_FALSE(!from_worker && include.target.rfind("worker/", 0) == 0) << include.file;
  }
}

}  // namespace
