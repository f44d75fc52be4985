// Processes that die: what they saved is there, and their runs can be told from those of the living.
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <functional>
#include <gtest/gtest.h>
#include <poll.h>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "coordinator/study/owner.hpp"
#include "tests/coordinator/study/study_fixture.hpp"

namespace coppice {
namespace {

using testing::StudyFiles;
using testing::WalkingEvaluator;

constexpr int kReportTimeoutMs = 60'000;

// A forked process that reports numbers over a pipe. Killed and reaped at the latest when this object goes.
class Child {
 public:
  // `work` runs in the child, which exits with what it returns.
  explicit Child(const std::function<int(const std::function<void(std::uint32_t)>& report)>& work) {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) {
      throw std::runtime_error("no pipe");
    }
    pid_ = ::fork();
    if (pid_ == 0) {
      ::close(ends[0]);
      const int status = work([&](std::uint32_t number) {
        if (::write(ends[1], &number, sizeof number) != sizeof number) {
          ::_exit(98);
        }
      });
      ::_exit(status);
    }
    ::close(ends[1]);
    reports_ = ends[0];
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    kill();
    ::close(reports_);
  }

  pid_t pid() const { return pid_; }

  std::optional<std::uint32_t> next_report() const {
    pollfd ready{reports_, POLLIN, 0};
    std::uint32_t number = 0;
    if (::poll(&ready, 1, kReportTimeoutMs) != 1 || ::read(reports_, &number, sizeof number) != sizeof number) {
      return std::nullopt;
    }
    return number;
  }

  // Dead but not reaped: a zombie.
  void kill_only() const {
    ::kill(pid_, SIGKILL);
    siginfo_t info{};
    ::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOWAIT);
  }

  void kill() {
    if (!reaped_) {
      ::kill(pid_, SIGKILL);
      wait();
    }
  }

  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    reaped_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = -1;
  int reports_ = -1;
  bool reaped_ = false;
};

class CrashTest : public StudyFiles {
 protected:
  // Opens the study, runs an evolution that would take for ever, and reports each generation once it is saved.
  int run_for_ever(const std::function<void(std::uint32_t)>& report) {
    auto study = Study::open(path_);
    if (!study) {
      return 1;
    }
    const auto run = study->begin_run({endless(), "serial"});
    WalkingEvaluator evaluator(chain_);
    const EvolveHooks hooks{[&](std::span<const GenerationRecord> records, const Checkpoint& checkpoint) {
      evaluator.calls.clear();
      auto ok = study->save_generations(*run, records, checkpoint);
      if (ok) {
        report(records.back().generation);
      }
      return ok;
    }};
    return run && evolve(chain_, endless(), evaluator, std::nullopt, hooks) ? 0 : 2;
  }

  static EvolveConfig endless() {
    EvolveConfig long_one = config();
    long_one.ga.generations = kMaxGenerations;
    return long_one;
  }
};

TEST_F(CrashTest, KillNineLosesNoGenerationThatWasSaved) {
  { make(); }
  for (int round = 1; round <= 3; ++round) {
    std::uint32_t saved = 0;
    {
      Child child([this](const auto& report) { return run_for_ever(report); });
      for (int i = 0; i < 5 * round; ++i) {
        const auto report = child.next_report();
        ASSERT_TRUE(report.has_value());
        saved = *report;
      }
    }
    auto study = Study::open(path_);
    ASSERT_TRUE(study.has_value()) << study.error().message;
    const RunRecord run = study->last_run().value().value();
    EXPECT_EQ(run.id, RunId{round});
    EXPECT_EQ(run.status, RunStatus::running);
    EXPECT_TRUE(run.abandoned);
    const auto resumed = study->resume_run(run.id);
    ASSERT_TRUE(resumed.has_value()) << resumed.error().message;
    EXPECT_GE(resumed->checkpoint->generation, saved);
    EXPECT_EQ(study->generations(run.id).value().size(), resumed->checkpoint->generation + 1);

    // What the dead process saved is what an evolution that nobody kills comes to.
    EvolveConfig same = resumed->config;
    same.ga.generations = resumed->checkpoint->generation + 1;
    WalkingEvaluator evaluator(chain_);
    std::optional<Checkpoint> reached;
    ASSERT_TRUE(evolve(chain_, same, evaluator, std::nullopt,
                       {[&](std::span<const GenerationRecord>, const Checkpoint& checkpoint) -> Result<void> {
                         reached = checkpoint;
                         return {};
                       }})
                    .has_value());
    EXPECT_EQ(resumed->checkpoint, reached);
    // Else it would be this process's, which is alive and keeps the next round's out.
    ASSERT_TRUE(study->finish_run(run.id, {RunStatus::interrupted, {}, {}}).has_value());
  }
  EXPECT_EQ(files(), std::vector<std::string>{"one.study"});
}

TEST_F(CrashTest, AKilledStudyCanBeReadWithoutBeingRepaired) {
  { make(); }
  {
    Child child([this](const auto& report) { return run_for_ever(report); });
    ASSERT_TRUE(child.next_report().has_value());
  }
  const auto study = Study::open(path_, Study::Access::read);
  ASSERT_TRUE(study.has_value()) << study.error().message;
  EXPECT_TRUE(study->load_checkpoint(RunId{1}).value().has_value());
}

TEST_F(CrashTest, ARunWhoseProcessIsAliveIsLeftToIt) {
  Study study = make();
  Child child([this](const auto& report) { return run_for_ever(report); });
  ASSERT_TRUE(child.next_report().has_value());
  const std::string refusal =
      path_ + ": run 1 is being run by process " + std::to_string(child.pid()) + ": stop it first";
  EXPECT_EQ(message(study.resume_run(RunId{1})), refusal);
  EXPECT_EQ(message(study.resume_run(RunId{1}, true)), refusal);
  ::kill(child.pid(), SIGSTOP);
  EXPECT_EQ(message(study.resume_run(RunId{1})), refusal) << "a stopped process can go on";
  child.kill_only();
  EXPECT_TRUE(study.run(RunId{1}).value().abandoned);
  EXPECT_TRUE(study.resume_run(RunId{1}).has_value()) << "nobody has collected its exit status yet";
}

TEST_F(CrashTest, AFinishedRunIsNotResumed) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  ASSERT_TRUE(study.finish_run(id, {}).has_value());
  EXPECT_EQ(message(study.resume_run(id)), path_ + ": run 1 is finished: expected one that is not");
  EXPECT_EQ(message(study.resume_run(RunId{7})), path_ + ": no run 7: expected 1 to 1");
}

TEST_F(CrashTest, AFailedRunIsResumedFromTheStartIfItSavedNothing) {
  Study study = make();
  const RunId id = study.begin_run({config(), "serial"}).value();
  ASSERT_TRUE(study.finish_run(id, {RunStatus::failed, {}, {}, R"({"error":"no worker"})"}).has_value());
  const auto resumed = study.resume_run(id);
  ASSERT_TRUE(resumed.has_value());
  EXPECT_EQ(resumed->checkpoint, std::nullopt);
  EXPECT_EQ(resumed->config, config());
}

TEST(Owner, IsAliveGoneOrOutOfSight) {
  const Owner here = this_process();
  EXPECT_EQ(here.pid, ::getpid());
  EXPECT_FALSE(here.start.empty());
  EXPECT_EQ(state_of(here), OwnerState::alive);
  Owner reused = here;
  reused.start = "1";
  EXPECT_EQ(state_of(reused), OwnerState::gone) << "the same number, another process";
  Owner before_boot = here;
  before_boot.boot = "0";
  EXPECT_EQ(state_of(before_boot), OwnerState::gone);
  before_boot.host = "elsewhere";
  EXPECT_EQ(state_of(before_boot), OwnerState::unknown);
  Owner contained = here;
  contained.space = "pid:[1]";
  EXPECT_EQ(state_of(contained), OwnerState::unknown);
}

// In a child, as limits and signals belong to a whole process. Writing past the limit fails as a full disk does.
class DiskFullTest : public StudyFiles {
 protected:
  static void limit_files_to(rlim_t bytes) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
};

TEST_F(DiskFullTest, AStudyThatDoesNotFitIsNotMade) {
  Child child([this](const auto&) {
    limit_files_to(8192);
    const auto study = Study::create(path_, chain_, world_, learning_);
    return !study && study.error().kind == ErrorKind::failed && study.error().message.rfind(path_ + ": ", 0) == 0 ? 0
                                                                                                                  : 1;
  });
  EXPECT_EQ(child.wait(), 0);
  EXPECT_EQ(files(), std::vector<std::string>());
}

TEST_F(DiskFullTest, AGenerationThatDoesNotFitIsAnErrorAndTheStudyStaysWhole) {
  { make(); }
  Child child([this](const auto& report) {
    Study study = Study::open(path_).value();
    const RunId id = study.begin_run({config(), "serial"}).value();
    Checkpoint checkpoint{0, std::vector<Tree>(100, Tree(ActionId{0})), std::vector<double>(100, 0.5), {}};
    if (!study.save_generations(id, std::vector<GenerationRecord>(1), checkpoint)) {
      return 1;
    }
    report(0);
    limit_files_to(1);
    checkpoint.generation = 1;
    GenerationRecord record;
    record.generation = 1;
    const auto ok = study.save_generations(id, {&record, 1}, checkpoint);
    return !ok && ok.error().kind == ErrorKind::failed && ok.error().message.rfind(path_ + ": ", 0) == 0 ? 0 : 2;
  });
  ASSERT_TRUE(child.next_report().has_value());
  EXPECT_EQ(child.wait(), 0);
  const auto study = Study::open(path_);
  ASSERT_TRUE(study.has_value()) << study.error().message;
  EXPECT_EQ(study->load_checkpoint(RunId{1}).value()->generation, 0U);
}

}  // namespace
}  // namespace coppice
