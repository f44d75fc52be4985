// What happens to processes, disks and clocks: each evolution ends with the serial result, bit for bit.
#include <fstream>
#include <iostream>
#include <random>
#include <signal.h>
#include <sys/mount.h>
#include <unistd.h>

#include "tests/e2e/hosts/remote_study.hpp"

namespace coppice::e2e {
namespace {

using namespace std::chrono_literals;

const std::vector<std::string> kPace = {"--pace", "2ms"};
const std::vector<std::string> kSettings = {"--seed", "4", "--set", "ga.generations=60"};

class Faults : public RemoteStudy {
 protected:
  Faults() { domain_ = "204"; }

  void kill_worker(Process& worker) const {
    worker.signal(SIGKILL);
    EXPECT_EQ(worker.wait().signal, SIGKILL);
  }

  void expect_serial_result(Process& coordinator, const nlohmann::json& expected) const {
    report_of(coordinator);
    expect_same_runs("study.coppice", expected);
  }
};

TEST_F(Faults, AWorkerKilledWhileItIsIdle) {
  const auto expected = serial_runs(kSettings);
  kill_worker(start_worker(0));
  Process& idle = start_worker(0);
  idle.await_error("looks for a coordinator");
  kill_worker(idle);
  start_worker(0);
  expect_serial_result(*start_coordinator(kSettings), expected);
}

TEST_F(Faults, AWorkerKilledWhileItReceivesTheChain) {
  // 13 MB, in 50 blocks.
  ASSERT_EQ(coppice({"synth", "-o", "large.coppice", "--states", "40000"}).ending, kDone);
  write("study.coppice", read("large.coppice"));
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=3", "--set", "ga.population=20"};
  const auto expected = serial_runs(settings);
  Process& receiving = start_worker(0);
  const auto coordinator = start_coordinator(settings);
  receiving.await_error("serving the coordinator");
  kill_worker(receiving);
  EXPECT_EQ(receiving.rest_of_error().find("holds chain"), std::string::npos) << "it was killed too late";
  start_worker(0);
  expect_serial_result(*coordinator, expected);
}

TEST_F(Faults, AWorkerKilledWhileItComputes) {
  const auto expected = serial_runs(kSettings);
  Process& computing = start_worker(0, {"--pace", "20ms"});  // it does next to nothing else
  start_worker(0, kPace);
  const auto coordinator = start_coordinator(kSettings);
  coordinator->await_error("2 workers");
  kill_worker(computing);
  expect_serial_result(*coordinator, expected);
}

TEST_F(Faults, WorkersKilledWhileTheyAnswerAgainAndAgain) {
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=400"};
  const auto expected = serial_runs(settings);
  start_worker(0);
  start_worker(0);  // without a pace they answer thousands of times a second
  const auto coordinator = start_coordinator(settings);
  for (int i = 0; i < 6; ++i) {
    coordinator->await_error("worker");
    kill_worker(*workers_[workers_.size() - 2]);
    start_worker(0);
  }
  expect_serial_result(*coordinator, expected);
}

TEST_F(Faults, AWorkerStoppedForLongerThanItsLease) {
  const auto expected = serial_runs({"--seed", "4", "--set", "ga.generations=100"});
  Process& stopped = start_worker(0, kPace);
  start_worker(0, kPace);
  const auto coordinator = start_coordinator({"--seed", "4", "--set", "ga.generations=100"});
  coordinator->await_error("2 workers");
  stopped.signal(SIGSTOP);
  coordinator->await_error("1 worker");  // its lease is over
  let_pass(1s);
  stopped.signal(SIGCONT);
  coordinator->await_error("2 workers");
  expect_serial_result(*coordinator, expected);
}

TEST_F(Faults, AllWorkersGoneAndNewOnes) {
  const auto expected = serial_runs(kSettings);
  Process& first = start_worker(0, kPace);
  Process& second = start_worker(0, kPace);
  const auto coordinator = start_coordinator(kSettings);
  coordinator->await_error("2 workers");
  kill_worker(first);
  kill_worker(second);
  coordinator->await_error("no worker is there");
  start_worker(0);
  expect_serial_result(*coordinator, expected);
}

TEST_F(Faults, AWorkerThatHoldsAnotherChain) {
  ASSERT_EQ(coppice({"learn", "-o", "other.coppice", "--episodes", "400", "--seed", "6"}).ending, kDone);
  const std::string learned = read("study.coppice");
  write("study.coppice", read("other.coppice"));
  Process& worker = start_worker(0);
  report_of(*start_coordinator(kSettings));
  write("study.coppice", learned);
  const auto expected = serial_runs(kSettings);
  expect_serial_result(*start_coordinator(kSettings), expected);
  worker.await_error("holds chain");
  worker.await_error("holds chain");
}

TEST_F(Faults, ACoordinatorKilledTwentyTimesAtRandomMomentsInOneRun) {
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=4000"};
  const auto expected = serial_runs(settings);
  const auto seed = std::random_device{}();
  std::cout << "random moments of seed " << seed << '\n';
  std::mt19937 random(seed);
  const auto here = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--workers", "2", "--lines-every", "1"});
    return std::make_unique<Process>(command(evolve("study.coppice", more)));
  };
  int killed = 0;
  for (; killed < 20; ++killed) {
    const auto coordinator = here(killed == 0 ? settings : std::vector<std::string>{"--resume"});
    coordinator->await_error("evolve: ");
    let_pass(std::chrono::milliseconds(random() % 30));
    if (!coordinator->running()) {
      break;
    }
    coordinator->signal(SIGKILL);
    EXPECT_EQ(coordinator->wait().signal, SIGKILL);
  }
  EXPECT_EQ(killed, 20);
  EXPECT_EQ(here({"--resume"})->wait(), kDone);
  expect_same_runs("study.coppice", expected);
}

TEST_F(Faults, AFullDisk) {
  std::filesystem::create_directory(path("small"));
  if (mount("coppice-test", path("small").c_str(), "tmpfs", 0, "size=64m") != 0) {
    GTEST_SKIP() << "a small file system cannot be mounted: that needs root";
  }
  struct Unmount {
    std::string path;
    ~Unmount() { umount2(path.c_str(), MNT_DETACH); }
  } const unmount{path("small")};
  // What so many generations leave in the study is more than the space that is left below.
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=6000"};
  const auto expected = serial_runs(settings);
  write("small/study.coppice", read("study.coppice"));
  {
    std::ofstream filler(path("small/filler"), std::ios::binary);
    const std::string block(4096, 'x');
    while (filler.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  }
  std::filesystem::resize_file(path("small/filler"), std::filesystem::file_size(path("small/filler")) - 300'000);

  const Completed full = coppice(evolve("small/study.coppice", [&] {
    auto more = settings;
    more.insert(more.end(), {"--workers", "1"});
    return more;
  }()));
  EXPECT_EQ(full.ending, kFailed) << full.error;
  EXPECT_NE(full.error.find("full"), std::string::npos) << full.error;
  std::filesystem::remove(path("small/filler"));
  const Completed resumed = coppice(evolve("small/study.coppice", {"--resume", "--workers", "1"}));
  EXPECT_EQ(resumed.ending, kDone) << full.error << resumed.error;
  expect_same_runs("small/study.coppice", expected);
}

TEST_F(Faults, DatagramsOfNonsenseAtEveryPort) {
  constexpr const char* kWorkerPort = "17500";
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=150"};
  const auto expected = serial_runs(settings);
  Process& worker = start_worker(0, {"--port", kWorkerPort, "--pace", "2ms"});
  start_worker(0, kPace);
  const auto coordinator = start_coordinator(settings);
  coordinator->await_error("2 workers");
  const std::string seed = std::to_string(std::random_device{}());
  std::cout << "datagrams of seed " << seed << '\n';
  Process pelt({.program = COPPICE_PELT,
                .arguments = {seed, "2", "127.0.0.1:" + std::to_string(7410 + 250 * 204),
                              std::string("127.0.0.1:") + kWorkerPort}});
  EXPECT_EQ(pelt.wait(), kDone) << pelt.rest_of_error();
  expect_serial_result(*coordinator, expected);
  EXPECT_TRUE(worker.running());
}

TEST_F(Faults, ClocksThatJump) {
  if (!std::filesystem::exists(kFakeTime)) {
    GTEST_SKIP() << "no " << kFakeTime << ": deploy/install-packages.sh tests installs it";
  }
  const std::vector<std::string> settings = {"--seed", "4", "--set", "ga.generations=80"};
  const auto expected = serial_runs(settings);
  write("clock", "+0");
  Process first(with_clock(worker(kPace)));
  start_worker(0, kPace);
  Process coordinator(with_clock(this->coordinator(settings)));
  for (const char* jump : {"+3600", "-86400", "+0", "-5"}) {
    coordinator.await_error("2 workers");
    write("clock", jump);
  }
  expect_serial_result(coordinator, expected);
}

}  // namespace
}  // namespace coppice::e2e
