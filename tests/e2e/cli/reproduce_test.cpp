// coppice reproduce thesis, small: every table is there, from real runs, the same over workers.
#include "tests/e2e/cli/command_line.hpp"

namespace coppice::e2e {
namespace {

class Reproduce : public CommandLine {
 protected:
  std::vector<std::string> small(const std::string& folder) const {
    return {"reproduce", "thesis", "-o", folder, "--episodes", "3000", "--seeds", "1", "--score-episodes", "20"};
  }
};

TEST_F(Reproduce, EveryTableStandsBesideThePrintedOne) {
  const Completed completed = coppice(small("r"));
  ASSERT_EQ(completed.ending, kDone) << completed.error;
  for (const char* table : {"Table IV:", "Easy verification:", "Table 5-1:", "Table 5-2:", "Table 5-3:", "Table 5-4:",
                            "Table 5-6:", "Table 5-7:", "Table 5-8:", "Table 4-1:", "Figure 4-4a:"}) {
    EXPECT_NE(completed.output.find(table), std::string::npos) << table;
  }
  const auto tables = nlohmann::json::parse(read("r/tables.json"), nullptr, false);
  EXPECT_EQ(tables.size(), 11U);
  EXPECT_EQ(tables[0]["rows"][3]["thesis"], nlohmann::json({"283", "248", "266"}));
  EXPECT_EQ(completed.output.rfind(read("r/tables.txt"), 0), 0U);
  // The studies keep every run, with its configuration.
  const auto info = coppice_json({"info", "r/uav.coppice", "--json"});
  EXPECT_EQ(info["runs"].size(), 5U);
  EXPECT_EQ(coppice_json({"info", "r/windy.coppice", "--json"})["runs"].size(), 1U);
  expect_wrong_use(small("r"), {"r", "exists"});
}

TEST_F(Reproduce, WorkersGiveTheSameTables) {
  auto remote = small("b");
  remote.insert(remote.end(), {"--workers", "2", "--worker-program", COPPICE_WORKER_PROGRAM});
  ASSERT_EQ(coppice(small("a")).ending, kDone);
  const Completed over_workers = coppice(remote);
  ASSERT_EQ(over_workers.ending, kDone) << over_workers.error;
  std::string serial = read("a/tables.txt");
  std::string workers = read("b/tables.txt");
  ASSERT_FALSE(serial.empty());
  // Nothing but the folder's name in the commands differs.
  for (std::size_t at = 0; (at = workers.find("b/uav.coppice", at)) != std::string::npos;) {
    workers[at] = 'a';
  }
  EXPECT_EQ(serial, workers);
}

TEST_F(Reproduce, WrongUseIsFoundBeforeTheFolderExists) {
  expect_wrong_use({"reproduce", "paper"}, {"paper", "thesis"});
  expect_wrong_use({"reproduce", "thesis", "--seeds", "0"}, {"--seeds", "0"});
  expect_wrong_use({"reproduce", "thesis", "--episodes", "0"}, {"--episodes", "0"});
  expect_wrong_use({"reproduce", "thesis", "--score-episodes", "1"}, {"--score-episodes", "1"});
  EXPECT_TRUE(files().empty());
}

}  // namespace
}  // namespace coppice::e2e
