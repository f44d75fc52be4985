#include "tests/e2e/process.hpp"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <fstream>
#include <map>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdexcept>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace coppice::e2e {
namespace {

void check(int error, const char* what) {
  if (error != 0) {
    throw std::system_error(error, std::generic_category(), what);
  }
}

struct Pipe {
  int read_end = -1;
  int write_end = -1;
};

Pipe new_pipe() {
  std::array<int, 2> ends{};
  check(pipe2(ends.data(), O_CLOEXEC) == 0 ? 0 : errno, "pipe2");
  return {ends[0], ends[1]};
}

std::vector<std::string> environment_with(const Command& command) {
  std::map<std::string, std::string> variables;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const std::size_t equals = text.find('=');
    variables[std::string(text.substr(0, equals))] = text.substr(equals + 1);
  }
  for (const auto& [name, value] : command.environment) {
    variables[name] = value;
  }
  std::vector<std::string> entries;
  for (const auto& [name, value] : variables) {
    entries.push_back(name + "=" + value);
  }
  return entries;
}

std::vector<char*> pointers_to(std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  for (std::string& text : strings) {
    pointers.push_back(text.data());
  }
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

Process::Process(const Command& command) {
  const Pipe input = new_pipe();
  const Pipe output = new_pipe();
  const Pipe error = new_pipe();
  std::vector<std::string> arguments = {command.program.string()};
  arguments.insert(arguments.end(), command.arguments.begin(), command.arguments.end());
  std::vector<std::string> environment = environment_with(command);

  posix_spawn_file_actions_t files;
  check(posix_spawn_file_actions_init(&files), "posix_spawn_file_actions_init");
  posix_spawn_file_actions_adddup2(&files, input.read_end, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, output.write_end, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, error.write_end, STDERR_FILENO);
  if (!command.folder.empty()) {
    posix_spawn_file_actions_addchdir_np(&files, command.folder.c_str());
  }
  // A child that ended early must not take the test with it; the child itself gets the usual way.
  ::signal(SIGPIPE, SIG_IGN);
  posix_spawnattr_t attributes;
  check(posix_spawnattr_init(&attributes), "posix_spawnattr_init");
  sigset_t signals;
  sigemptyset(&signals);
  posix_spawnattr_setsigmask(&attributes, &signals);
  sigaddset(&signals, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  const int failure = posix_spawn(&pid_, command.program.c_str(), &files, &attributes, pointers_to(arguments).data(),
                                  pointers_to(environment).data());
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  close(input.read_end);
  close(output.write_end);
  close(error.write_end);
  input_ = input.write_end;
  output_.descriptor = output.read_end;
  error_.descriptor = error.read_end;
  check(failure, command.program.c_str());
  ended_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));  // sys/pidfd.h of glibc 2.36 is not for C++
  check(ended_ >= 0 ? 0 : errno, "pidfd_open");
  for (const Stream* stream : {&output_, &error_}) {
    fcntl(stream->descriptor, F_SETFL, O_NONBLOCK);
  }
}

Process::~Process() {
  if (!ending_ && pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  close_input();
  close_stream(output_);
  close_stream(error_);
  if (ended_ >= 0) {
    close(ended_);
  }
}

void Process::close_stream(Stream& stream) {
  if (stream.descriptor >= 0) {
    close(std::exchange(stream.descriptor, -1));
  }
}

void Process::close_input() {
  if (input_ >= 0) {
    close(std::exchange(input_, -1));
  }
}

bool Process::take_in(Stream& stream) {
  std::array<char, 65536> bytes{};
  const ssize_t size = stream.descriptor < 0 ? 0 : read(stream.descriptor, bytes.data(), bytes.size());
  if (size > 0) {
    stream.buffer.append(bytes.data(), static_cast<std::size_t>(size));
    return true;
  }
  if (size == 0 || errno != EAGAIN) {
    close_stream(stream);
  }
  return false;
}

void Process::take_in_until(const std::function<bool()>& done) {
  const auto begin = std::chrono::steady_clock::now();
  while (!done()) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(begin + kPatience - std::chrono::steady_clock::now());
    std::array<pollfd, 3> sources = {
        {{output_.descriptor, POLLIN, 0}, {error_.descriptor, POLLIN, 0}, {ending_ ? -1 : ended_, POLLIN, 0}}};
    if (left.count() <= 0 || poll(sources.data(), sources.size(), static_cast<int>(left.count())) == 0) {
      kill(pid_, SIGKILL);
      throw std::runtime_error("a child process kept a test waiting; it printed:\n" + output_.buffer + error_.buffer);
    }
    take_in(output_);
    take_in(error_);
    running();
    if (ending_) {
      // Its own children may hold the pipes open for longer; what it wrote itself is there by now.
      while (take_in(output_) || take_in(error_)) {
      }
      close_stream(output_);
      close_stream(error_);
    }
  }
}

bool Process::running() {
  if (ending_) {
    return false;
  }
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) {
    return true;
  }
  ending_ = WIFEXITED(status) ? Ending{WEXITSTATUS(status), 0} : Ending{std::nullopt, WTERMSIG(status)};
  return false;
}

std::optional<std::string> Process::read_line(Stream& stream) {
  take_in_until([&] { return stream.buffer.find('\n') != std::string::npos || stream.descriptor < 0; });
  if (stream.buffer.empty()) {
    return std::nullopt;
  }
  const std::size_t end = stream.buffer.find('\n');
  std::string line = stream.buffer.substr(0, end);
  stream.buffer.erase(0, end == std::string::npos ? end : end + 1);
  return line;
}

std::string Process::await_line(Stream& stream, std::string_view text) {
  std::string before;
  while (std::optional<std::string> line = read_line(stream)) {
    if (line->find(text) != std::string::npos) {
      return *line;
    }
    before += *line + '\n';
  }
  throw std::runtime_error("a child process ended without printing '" + std::string(text) + "'; it printed:\n" +
                           before);
}

void Process::write_input(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(input_, text.data(), text.size());
    if (written < 0 && errno == EPIPE) {
      return;  // how it ended is for the test to ask
    }
    if (written < 0 && errno != EINTR) {
      check(errno, "write to a child process");
    }
    text.remove_prefix(written > 0 ? static_cast<std::size_t>(written) : 0);
  }
}

void Process::signal(int number) const { check(kill(pid_, number) == 0 ? 0 : errno, "kill"); }

void Process::await_blocked(int number) {
  const auto begin = std::chrono::steady_clock::now();
  const std::string path = "/proc/" + std::to_string(pid_) + "/status";
  constexpr std::string_view kField = "SigBlk:";
  while (true) {
    std::ifstream status(path);
    for (std::string line; std::getline(status, line);) {
      if (line.starts_with(kField) &&
          (std::stoull(line.substr(kField.size()), nullptr, 16) >> (number - 1) & 1U) != 0) {
        return;
      }
    }
    if (!running() || std::chrono::steady_clock::now() - begin > kPatience) {
      throw std::runtime_error("a child process never blocked signal " + std::to_string(number));
    }
    std::this_thread::yield();
  }
}

Ending Process::wait() {
  take_in_until([&] { return ending_.has_value() && output_.descriptor < 0 && error_.descriptor < 0; });
  return *ending_;
}

Completed run_to_end(const Command& command, std::string_view input) {
  Process process(command);
  if (!input.empty()) {
    process.write_input(input);
  }
  process.close_input();
  const Ending ending = process.wait();
  return {ending, process.rest_of_output(), process.rest_of_error()};
}

}  // namespace coppice::e2e
