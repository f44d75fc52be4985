#include "coordinator/learning/child_process.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace coppice {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxErrorLine = 1000;  // characters kept of a line

void close_one(int& descriptor) {
  if (descriptor >= 0) {
    ::close(descriptor);
    descriptor = -1;
  }
}

std::string ending_of(int status) {
  return WIFEXITED(status) ? fmt::format("it ended with exit code {}", WEXITSTATUS(status))
                           : fmt::format("signal {} ended it", WTERMSIG(status));
}

int remaining_ms(Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
  return static_cast<int>(std::clamp<long long>(left, 0, 60'000));
}

}  // namespace

Result<ChildProcess> ChildProcess::start(const std::string& command, const StopFlag* stop) {
  // A socket, not a pipe, so that writing to a child that is gone is an error and not a signal.
  std::array<int, 2> to{-1, -1};
  std::array<int, 2> from{-1, -1};
  std::array<int, 2> errors{-1, -1};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, to.data()) != 0 || pipe2(from.data(), O_CLOEXEC) != 0 ||
      pipe2(errors.data(), O_CLOEXEC) != 0) {
    const std::string reason = std::strerror(errno);
    for (int descriptor : {to[0], to[1], from[0], from[1], errors[0], errors[1]}) {
      close_one(descriptor);
    }
    return failed(fmt::format("cannot start the simulator: {}", reason));
  }
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, to[1], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, from[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, errors[1], STDERR_FILENO);
  // The signals that stop us are blocked here (stop.hpp) and would stay blocked there.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
  std::string shell = "/bin/sh";
  std::string flag = "-c";
  std::string script = command;
  std::array<char*, 4> argv{shell.data(), flag.data(), script.data(), nullptr};
  ChildProcess child;
  const int error = posix_spawn(&child.pid_, shell.c_str(), &files, &attributes, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  close_one(to[1]);
  close_one(from[1]);
  close_one(errors[1]);
  child.to_ = to[0];
  child.from_ = from[0];
  child.errors_ = errors[0];
  if (error != 0) {
    child.pid_ = -1;
    return failed(fmt::format("cannot start the simulator: {}", std::strerror(error)));
  }
  for (const int descriptor : {child.to_, child.from_, child.errors_}) {
    fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  }
  if (stop != nullptr) {
    child.stop_ = stop;
    child.wake_up_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (child.wake_up_ < 0) {
      return failed(fmt::format("cannot start the simulator: {}", std::strerror(errno)));
    }
    child.wake_ = stop->on_raise([wake_up = child.wake_up_] {
      const std::uint64_t one = 1;
      static_cast<void>(!::write(wake_up, &one, sizeof(one)));  // it can only fail where it is awake already
    });
  }
  return child;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept { *this = std::move(other); }

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  if (this != &other) {
    end();
    stop_ = std::exchange(other.stop_, nullptr);
    wake_ = std::move(other.wake_);
    wake_up_ = std::exchange(other.wake_up_, -1);
    pid_ = std::exchange(other.pid_, -1);
    to_ = std::exchange(other.to_, -1);
    from_ = std::exchange(other.from_, -1);
    errors_ = std::exchange(other.errors_, -1);
    buffer_ = std::move(other.buffer_);
    error_buffer_ = std::move(other.error_buffer_);
    error_lines_ = std::move(other.error_lines_);
  }
  return *this;
}

ChildProcess::~ChildProcess() { end(); }

void ChildProcess::end() noexcept {
  close_one(to_);
  close_one(from_);
  if (pid_ > 0) {
    int status = 0;
    bool left = false;
    for (const int signal : {0, SIGTERM, SIGKILL}) {
      if (signal != 0) {
        kill(-pid_, signal);
      }
      const Clock::time_point deadline =
          Clock::now() + (signal == 0 && stopped() ? std::chrono::milliseconds(0) : kPatience);
      // Ends with the deadline; a killed process is waited for as long as it takes.
      while (!left && (signal == SIGKILL || Clock::now() < deadline)) {
        const pid_t waited = waitpid(pid_, &status, signal == SIGKILL ? 0 : WNOHANG);
        left = waited == pid_ || (waited < 0 && errno == ECHILD);
        if (!left && signal != SIGKILL) {
          std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
      }
      if (left) {
        break;
      }
    }
    kill(-pid_, SIGKILL);  // whoever it started and left behind
    pid_ = -1;
  }
  close_one(errors_);
  wake_ = {};  // before what it writes to
  close_one(wake_up_);
}

void ChildProcess::drain_errors() {
  std::array<char, 4096> bytes{};
  // Ends when there is nothing more to read just now.
  while (errors_ >= 0) {
    const ssize_t size = ::read(errors_, bytes.data(), bytes.size());
    if (size < 0 && errno == EINTR) {
      continue;
    }
    if (size == 0) {
      close_one(errors_);
    }
    if (size <= 0) {
      return;
    }
    for (const char c : std::string_view(bytes.data(), static_cast<std::size_t>(size))) {
      if (c != '\n') {
        if (error_buffer_.size() < kMaxErrorLine) {
          error_buffer_ += c;
        }
        continue;
      }
      error_lines_.push_back(std::exchange(error_buffer_, {}));
      if (error_lines_.size() > kKeptErrorLines) {
        error_lines_.pop_front();
      }
    }
  }
}

bool ChildProcess::wait_for(bool want_write, Clock::time_point deadline) {
  std::array<pollfd, 4> polled{pollfd{from_, POLLIN, 0}, pollfd{errors_, POLLIN, 0},
                               pollfd{want_write ? to_ : -1, POLLOUT, 0}, pollfd{wake_up_, POLLIN, 0}};
  const int ready = poll(polled.data(), polled.size(), remaining_ms(deadline));
  readable_ = ready > 0 && polled[0].revents != 0;
  writable_ = ready > 0 && polled[2].revents != 0;
  if (ready > 0 && polled[1].revents != 0) {
    drain_errors();
  }
  return ready > 0 || Clock::now() < deadline;
}

std::string ChildProcess::last_words() {
  drain_errors();
  std::string words;
  for (const std::string& line : error_lines_) {
    words += "\n  " + line;
  }
  return error_buffer_.empty() ? words : words + "\n  " + error_buffer_;
}

tl::unexpected<Error> ChildProcess::gone() {
  int status = 0;
  const Clock::time_point deadline = Clock::now() + kPatience;
  pid_t waited = 0;
  // Ends with the deadline: it has closed its output, so it leaves about now.
  while (waited == 0 && Clock::now() < deadline) {
    waited = waitpid(pid_, &status, WNOHANG);
    if (waited == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  std::string how = "it closed its standard output";
  if (waited == pid_) {
    kill(-pid_, SIGKILL);  // whoever it started and left behind
    pid_ = -1;
    how = ending_of(status);
  }
  const std::string words = last_words();
  return failed(how + (words.empty() ? "" : "; on standard error it said:" + words));
}

Result<void> ChildProcess::write_line(std::string_view line, std::chrono::milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  std::string whole(line);
  whole += '\n';
  std::string_view rest = whole;
  // Every turn waits for the child, until the deadline.
  while (!rest.empty()) {
    if (stopped()) {
      return interrupted();
    }
    const ssize_t sent = send(to_, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (sent >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(sent));
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      if (!wait_for(true, deadline)) {
        return failed(fmt::format("it did not read for {} s", std::chrono::duration<double>(timeout).count()) +
                      last_words());
      }
    } else if (errno != EINTR) {
      return gone();
    }
  }
  return {};
}

Result<std::string> ChildProcess::read_line(std::chrono::milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  std::size_t searched = 0;
  // Every turn waits for the child, until the deadline.
  while (true) {
    if (stopped()) {
      return interrupted();
    }
    if (const std::size_t end = buffer_.find('\n', searched); end != std::string::npos) {
      std::string line = buffer_.substr(0, end);
      buffer_.erase(0, end + 1);
      return line;
    }
    searched = buffer_.size();
    if (buffer_.size() > kMaxLine) {
      return failed(fmt::format("a line of more than {} bytes", kMaxLine));
    }
    if (!wait_for(false, deadline)) {
      const std::string words = last_words();
      return failed(fmt::format("it did not answer for {} s", std::chrono::duration<double>(timeout).count()) +
                    (words.empty() ? "" : "; on standard error it said:" + words));
    }
    if (!readable_) {
      continue;
    }
    std::array<char, 65536> bytes;
    const ssize_t size = ::read(from_, bytes.data(), bytes.size());
    if (size == 0) {
      return gone();
    }
    if (size > 0) {
      buffer_.append(bytes.data(), static_cast<std::size_t>(size));
    } else if (errno != EINTR && errno != EAGAIN && errno != EWOULDBLOCK) {
      return gone();
    }
  }
}

}  // namespace coppice
