// A child process whose standard streams are in a test's hands: started without a shell, read line by line, signalled,
// waited for. Both output streams are taken in whenever something is awaited, so a child never blocks on a full pipe. A
// wait that goes past kPatience kills the child and throws with what it printed: a hang fails a test instead of hanging
// it. Used by one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <sys/types.h>
#include <utility>
#include <vector>

namespace coppice::e2e {

inline constexpr std::chrono::seconds kPatience{240};  // for any one wait; far beyond what any takes

struct Command {
  std::filesystem::path program;
  std::vector<std::string> arguments;
  std::filesystem::path folder = {};                                  // to start in; empty: this process' own
  std::vector<std::pair<std::string, std::string>> environment = {};  // set beside, or over, this process' own
};

struct Ending {
  std::optional<int> exit_code;  // empty: killed by `signal`
  int signal = 0;
  bool operator==(const Ending&) const = default;
};

class Process {
 public:
  // Throws std::system_error when the program cannot be started.
  explicit Process(const Command& command);
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process();  // kills and reaps what still runs

  pid_t pid() const { return pid_; }
  bool running();

  // The next line without its line feed; empty at the end of the stream.
  std::optional<std::string> read_output_line() { return read_line(output_); }
  std::optional<std::string> read_error_line() { return read_line(error_); }
  // Reads on until a line that contains `text`. Throws when the stream ends first.
  std::string await_output(std::string_view text) { return await_line(output_, text); }
  std::string await_error(std::string_view text) { return await_line(error_, text); }

  void write_input(std::string_view text);  // to nobody, once the child has ended
  void close_input();

  void signal(int number) const;
  // Returns once the child has blocked the signal for itself (signalfd, sigwait): from then on it is not killed by it.
  void await_blocked(int number);

  // Waits for the end. What was printed and not yet read can then be read, or taken at once.
  Ending wait();
  std::string rest_of_output() { return std::exchange(output_.buffer, {}); }
  std::string rest_of_error() { return std::exchange(error_.buffer, {}); }

 private:
  struct Stream {
    int descriptor = -1;
    std::string buffer;  // read from the pipe, not yet from us
  };

  std::optional<std::string> read_line(Stream& stream);
  std::string await_line(Stream& stream, std::string_view text);
  void take_in_until(const std::function<bool()>& done);
  bool take_in(Stream& stream);  // false when nothing was there
  void close_stream(Stream& stream);

  pid_t pid_ = -1;
  int ended_ = -1;  // pidfd, readable once the child has ended
  int input_ = -1;
  Stream output_;
  Stream error_;
  std::optional<Ending> ending_;
};

struct Completed {
  Ending ending;
  std::string output;
  std::string error;
};

// Runs to the end with `input` on standard input.
Completed run_to_end(const Command& command, std::string_view input = {});

}  // namespace coppice::e2e
