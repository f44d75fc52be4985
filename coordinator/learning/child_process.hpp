// A child process that is spoken to in lines: what it reads is written to it, what it writes is read with a deadline,
// what it says on standard error is kept for messages. Owns the process and three pipes. Its own process group, so that
// Ctrl-C in a terminal stops us and we end it. One thread.
#pragma once

#include <chrono>
#include <deque>
#include <string>
#include <string_view>
#include <sys/types.h>

#include "common/error.hpp"
#include "common/stop.hpp"

namespace coppice {

class ChildProcess {
 public:
  static constexpr std::size_t kMaxLine = std::size_t{64} << 20U;  // bytes of a line that it writes
  static constexpr std::size_t kKeptErrorLines = 20;

  // Runs `command` by /bin/sh. When `stop` is raised, whoever waits for the child returns at once with `interrupted`,
  // and the child is terminated without being given time to leave by itself. Error (failed): no process or pipe can be
  // had. REQUIRES: `stop`, if not null, outlives this.
  static Result<ChildProcess> start(const std::string& command, const StopFlag* stop = nullptr);

  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  // Closes its input, gives it kPatience to leave (none when it was stopped), then terminates and at last kills its
  // process group.
  ~ChildProcess();

  // Writes a line; while it waits, standard error is read, so that neither side blocks the other. Errors (failed): it
  // is gone; the deadline passed; interrupted.
  Result<void> write_line(std::string_view line, std::chrono::milliseconds timeout);

  // Without the line end. Errors (failed): it is gone, with exit code or signal and its last lines on standard error;
  // the deadline passed; a line of more than kMaxLine bytes; interrupted.
  Result<std::string> read_line(std::chrono::milliseconds timeout);

  // The last lines on standard error, indented, each on a line of its own; empty if there are none.
  std::string last_words();

 private:
  static constexpr std::chrono::milliseconds kPatience{2000};

  ChildProcess() = default;
  void end() noexcept;
  bool stopped() const { return stop_ != nullptr && stop_->raised(); }
  // Waits until one of the pipes can be used. False: the deadline passed.
  bool wait_for(bool want_write, std::chrono::steady_clock::time_point deadline);
  void drain_errors();
  tl::unexpected<Error> gone();

  const StopFlag* stop_ = nullptr;
  int wake_up_ = -1;  // eventfd, written when the flag is raised
  StopFlag::Wake wake_;
  pid_t pid_ = -1;
  int to_ = -1;
  int from_ = -1;
  int errors_ = -1;
  bool readable_ = false;  // after wait_for()
  bool writable_ = false;
  std::string buffer_;        // read, not yet handed out
  std::string error_buffer_;  // the line of standard error that is under way
  std::deque<std::string> error_lines_;
};

}  // namespace coppice
