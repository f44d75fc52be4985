#include "coordinator/console/progress.hpp"

#include <array>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>

namespace coppice {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class Output {
 public:
  Output() : file_(std::tmpfile()) {}
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  ~Output() { std::fclose(file_); }
  std::FILE* file() { return file_; }
  std::string text() {
    std::fflush(file_);
    std::rewind(file_);
    std::array<char, 4096> bytes{};
    return {bytes.data(), std::fread(bytes.data(), 1, bytes.size(), file_)};
  }

 private:
  std::FILE* file_;
};

const Clock::time_point kBegin{std::chrono::hours(5)};

TEST(ProgressLine, HasBarFiguresRateAndTimeLeft) {
  const ProgressAt at{.label = "evolve",
                      .unit = "generations",
                      .begin = 0,
                      .done = 100,
                      .total = 400,
                      .elapsed = seconds(10),
                      .extra = "best 0.9"};
  EXPECT_EQ(plain_line(at), "evolve: 100/400 generations, 10.0/s, 30 s left, best 0.9");
  EXPECT_EQ(redrawn_line(at, 200), "evolve [#####...............] 100/400 generations, 10.0/s, 30 s left, best 0.9");
}

TEST(ProgressLine, WhatAnEarlierProcessDidCountsForTheBarButNotForTheRate) {
  const ProgressAt at{
      .label = "evolve", .unit = "", .begin = 300, .done = 350, .total = 400, .elapsed = seconds(50), .extra = ""};
  EXPECT_EQ(plain_line(at), "evolve: 350/400, 1.0/s, 50 s left");
}

TEST(ProgressLine, BeforeAnythingIsDoneThereIsNoRate) {
  const ProgressAt at{
      .label = "learn", .unit = "", .begin = 0, .done = 0, .total = 9, .elapsed = seconds(0), .extra = ""};
  EXPECT_EQ(plain_line(at), "learn: 0/9");
}

TEST(ProgressLine, IsCutBeforeTheTerminalWouldWrapIt) {
  const std::string extra(300, 'x');
  const ProgressAt at{
      .label = "evolve", .unit = "", .begin = 0, .done = 1, .total = 2, .elapsed = seconds(1), .extra = extra};
  EXPECT_EQ(redrawn_line(at, 80).size(), 79U);
  EXPECT_EQ(redrawn_line(at, 0).size(), 19U);
}

TEST(Progress, PlainLinesComeAtMultiples) {
  Output output;
  {
    Progress progress(output.file(), {.plain_every = milliseconds(0), .plain_every_done = 10}, "evolve", "", 35, 0,
                      kBegin);
    for (std::uint64_t done = 1; done <= 35; ++done) {
      progress.update(done, {}, kBegin + seconds(done));
    }
  }
  EXPECT_EQ(output.text(),
            "evolve: 10/35, 1.0/s, 25 s left\n"
            "evolve: 20/35, 1.0/s, 15 s left\n"
            "evolve: 30/35, 1.0/s, 5 s left\n");
}

TEST(Progress, PlainLinesComeByTimeWhereNothingElseBringsThem) {
  Output output;
  Progress progress(output.file(), {.plain_every = seconds(10), .plain_every_done = 0}, "learn", "", 100, 0, kBegin);
  progress.update(1, {}, kBegin + milliseconds(9999));
  progress.update(2, {}, kBegin + seconds(10));
  progress.update(3, {}, kBegin + seconds(11));
  EXPECT_EQ(output.text(), "learn: 2/100, 0.2/s, 8 min 10 s left\n");
}

TEST(Progress, ARedrawnLineCoversTheOneBeforeAndIsClearedInTheEnd) {
  Output output;
  {
    Progress progress(output.file(), {.redraw = true, .columns = 60}, "e", "", 0, 0, kBegin);
    progress.update(1, "long", kBegin);
    progress.update(2, "unseen", kBegin + milliseconds(99));
    progress.update(3, "", kBegin + milliseconds(100));
  }
  EXPECT_EQ(output.text(), "\re 1, long\re 3, 30.0/s" + std::string("\r           \r"));
}

TEST(Progress, ALineOfItsOwnGoesAboveTheRedrawnOne) {
  Output output;
  Progress progress(output.file(), {.redraw = true, .columns = 60}, "e", "", 0, 0, kBegin);
  progress.update(1, "", kBegin);
  progress.say("a worker left");
  EXPECT_EQ(output.text(), "\re 1\r   \ra worker left\ne 1");
}

TEST(Progress, ExtraTextIsMadePrintable) {
  Output output;
  Progress progress(output.file(), {.plain_every_done = 1}, "e", "", 0, 0, kBegin);
  progress.update(1, "\x1b[2J", kBegin);
  EXPECT_EQ(output.text(), "e: 1, \\x1b[2J\n");
}

TEST(Progress, GoesOnWhereNothingCanBeShown) {
  std::FILE* full = std::fopen("/dev/full", "w");
  ASSERT_NE(full, nullptr);
  {
    Progress progress(full, {.redraw = true}, "learn", "episodes", 2);
    progress.update(1);
    progress.say("a line");
    progress.finish(2);
  }
  std::fclose(full);
}

}  // namespace
}  // namespace coppice
