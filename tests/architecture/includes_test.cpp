// The arrows between the folders, held against every #include: who may know whom. A folder that is not listed, or an
// include that breaks an arrow, fails the test.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

// Folder -> the project folders that it may include besides itself. "common" stands for the files right inside it.
const std::map<std::string, std::set<std::string>> kArrows = {
    {"common", {}},
    {"common/tree", {"common"}},
    {"common/chain", {"common", "common/tree"}},
    {"common/fitness", {"common", "common/tree", "common/chain"}},
    {"common/wire", {"common", "common/tree", "common/chain", "common/fitness"}},
    {"worker", {"common", "common/tree", "common/chain", "common/fitness", "common/wire"}},
    {"coordinator/learning", {"common", "common/tree", "common/chain"}},
    {"coordinator/dispatch", {"common", "common/tree", "common/chain", "common/fitness", "common/wire"}},
    {"coordinator/bench",
     {"common", "common/tree", "common/chain", "common/fitness", "coordinator/dispatch", "coordinator/report"}},
    {"coordinator/evolution", {"common", "common/tree", "common/chain", "common/fitness", "coordinator/dispatch"}},
    {"coordinator/study",
     {"common", "common/tree", "common/chain", "common/fitness", "coordinator/learning", "coordinator/evolution"}},
    {"coordinator/report",
     {"common", "common/tree", "common/chain", "common/fitness", "coordinator/learning", "coordinator/evolution",
      "coordinator/study", "coordinator/dispatch"}},
    {"coordinator/trust", {"common", "common/tree", "common/chain", "coordinator/learning", "coordinator/report"}},
    {"coordinator/refine",
     {"common", "common/tree", "common/chain", "coordinator/learning", "coordinator/evolution", "coordinator/study",
      "coordinator/report"}},
    {"coordinator/reproduce",
     {"common", "common/tree", "common/chain", "coordinator/learning", "coordinator/evolution", "coordinator/dispatch",
      "coordinator/study", "coordinator/report", "coordinator/trust"}},
    {"coordinator/sweep",
     {"common", "common/tree", "common/chain", "common/fitness", "coordinator/learning", "coordinator/dispatch",
      "coordinator/evolution", "coordinator/report"}},
    {"coordinator/commands",
     {"common", "common/tree", "common/chain", "common/fitness", "coordinator", "coordinator/learning",
      "coordinator/dispatch", "coordinator/bench", "coordinator/evolution", "coordinator/study", "coordinator/report",
      "coordinator/sweep", "coordinator/trust", "coordinator/refine", "coordinator/reproduce"}},
    {"coordinator", {"common", "coordinator/commands", "coordinator/report"}},
};

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
  for (const Include& include : includes) {
    if (!include.quoted) {
      continue;
    }
    const auto arrows = kArrows.find(include.folder);
    ASSERT_NE(arrows, kArrows.end()) << include.folder << " has no arrows: add it to this test and to README.md";
    const std::string target = folder_of(include.target);
    EXPECT_TRUE(target == include.folder || arrows->second.count(target) != 0)
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

TEST(Architecture, InTheCoordinatorOnlyRemoteDispatchKnowsTheWire) {
  for (const Include& include : all_includes()) {
    if (include.quoted && folder_of(include.target) == "common/wire" && include.folder != "worker" &&
        include.folder != "common/wire") {
      EXPECT_EQ(include.file.rfind("coordinator/dispatch/remote_", 0), 0U) << include.file;
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
