// A worker that is started again with the same --cache is not sent what it had: real processes, kill -9.
#include <filesystem>
#include <fstream>
#include <signal.h>

#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

class WorkerCache : public RemoteStudy {
 protected:
  WorkerCache() { domain_ = "209"; }

  void SetUp() override {
    // 13 MB, in 51 blocks.
    ASSERT_EQ(coppice({"synth", "-o", "study.coppice", "--states", "40000"}).ending, kDone);
    settings_ = {"--seed", "4", "--set", "ga.generations=3", "--set", "ga.population=20"};
    expected_ = serial_runs(settings_);
    fresh_ = read("study.coppice");
  }

  // A worker with the cache, and an evolution by it. Returns what it said of the chain until it held it.
  std::string evolve_with_worker() {
    write("study.coppice", fresh_);
    Process& worker = start_worker(0, {"--cache", path("cache")});
    const auto coordinator = start_coordinator(settings_);
    std::string said;
    while (said.find("holds chain") == std::string::npos) {
      const auto line = worker.read_error_line();
      if (!line) {
        ADD_FAILURE() << "the worker ended: " << said;
        break;
      }
      said += *line + '\n';
    }
    report_of(*coordinator);
    expect_same_runs("study.coppice", expected_);
    worker.signal(SIGKILL);
    EXPECT_EQ(worker.wait().signal, SIGKILL);
    return said;
  }
  std::filesystem::path file() const { return std::filesystem::directory_iterator(path("cache"))->path(); }

  std::vector<std::string> settings_;
  nlohmann::json expected_;
  std::string fresh_;
};

TEST_F(WorkerCache, OutlivesTheWorker) {
  const std::string first = evolve_with_worker();
  EXPECT_EQ(first.find("in the cache"), std::string::npos) << first;
  const std::string again = evolve_with_worker();
  EXPECT_NE(again.find("51 of 51 blocks are in the cache"), std::string::npos) << again;
  // As of a worker that was killed in the middle of a transfer.
  std::filesystem::resize_file(file(), 20 * 262144 + 1000);
  const std::string rest = evolve_with_worker();
  EXPECT_NE(rest.find("20 of 51 blocks are in the cache"), std::string::npos) << rest;
  EXPECT_NE(evolve_with_worker().find("51 of 51 blocks are in the cache"), std::string::npos);
}

TEST_F(WorkerCache, IsNotBelieved) {
  evolve_with_worker();
  {
    std::fstream damage(file(), std::ios::in | std::ios::out | std::ios::binary);
    damage.seekp(1'000'000);
    damage << "damage";
  }
  const std::string said = evolve_with_worker();
  EXPECT_NE(said.find("51 of 51 blocks are in the cache"), std::string::npos) << said;
  EXPECT_NE(said.find("do not have its hash"), std::string::npos) << said;
}

TEST_F(WorkerCache, MustBeAFolder) {
  const Completed completed = run_to_end(
      {.program = COPPICE_WORKER_PROGRAM, .arguments = {"--cache", "/dev/null"}, .folder = {}, .environment = {}});
  EXPECT_EQ(completed.ending, kWrongUse);
  EXPECT_NE(completed.error.find("--cache: /dev/null"), std::string::npos) << completed.error;
}

}  // namespace
}  // namespace coppice::e2e
